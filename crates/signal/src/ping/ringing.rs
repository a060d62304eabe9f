//! Noise that rings the mode: a flow drives it while it decays, as it did before the forcing.
//!
//! White noise that drives a mode s gives its amplitude a part xi with E xi(t) xi*(t') = R e^{-a|t-t'|}
//! e^{i omega (t-t')}, a = -Re s: as narrow as the mode itself, and of its shape. A fit by least squares
//! stays without bias, its errors become larger. With weights e^{-at} the perturbation of ln(amplitude) is
//! xi/(b e^{st}); growth rate, frequency and drift are linear in it, and their variances are double sums of
//! these weights with the covariance above, which one pass over the rows gives. R follows from innovations,
//! of the mean z_j over stretch j of length D: z_{j+1} less e^{-a D} z_j. They are nearly independent:
//! silence and tail hold a few decay times, and many such stretches.

use super::chirp::Drift;
use super::excess::{Excess, Excesses};
use super::power::Power;
use super::resolution::deviation;
use super::verdict::{loudness, tones};
use crate::dsp::kernels::dot;
use crate::ringdown::{Solution, White};
use rijke_numerics::{C64, Matrix};
use rijke_rig::Ping;
use std::f64::consts::TAU;

/// Power of the silence beside the mode's frequency over that farther away, from which noise rings it.
const RINGS: f64 = 8.0;
/// Distances at which the two are measured, in resolutions of the silence.
const NEAR: [f64; 3] = [-1.0, 0.0, 1.0];
const AWAY: [f64; 6] = [-9.0, -7.0, -5.0, 5.0, 7.0, 9.0];
/// Periods in which noise that rings the mode is taken out of a record.
const CALMED: f64 = 2.0;
/// What is taken of a power that was found, so that chance does not make it too small.
const LOUDER: f64 = 1.5;
const TWICE: f64 = 2.0;
/// Energy of narrow noise, over its mean, that chance does not reach.
pub(crate) const CHANCE: f64 = 10.0;

/// Power R of the noise that rings the mode, in units of the white noise: none where it is zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Ringing {
    pub(crate) power: f64,
    /// Growth rate and frequency of the mode, 1/s, as far as they are known.
    pub(crate) s: C64,
}

impl Ringing {
    /// What the energy of a tone of the frequency `omega`, in rows a time `step` apart, may be by chance.
    pub(crate) fn energy(&self, omega: f64, step: f64) -> f64 {
        let (a, apart) = (-self.s.re, omega - self.s.im);
        if self.is_some() { CHANCE * self.power * a / (step * (a * a + apart * apart)) } else { 0.0 }
    }

    /// The same at the frequency of the mode.
    pub(crate) fn close_energy(&self, step: f64) -> f64 {
        self.energy(self.s.im, step)
    }

    /// Variance of white noise of the given variance with this noise, per channel and row, at most.
    pub(crate) fn added_to(&self, noise: f64, channels: usize) -> f64 {
        noise + 2.0 * self.power / channels.max(1) as f64
    }

    /// The same of a mode that is better known, whose noise has another power.
    pub(crate) fn at_least(self, power: Option<Power>, s: C64) -> Self {
        let found = power.map_or(0.0, |p| LOUDER * p.value);
        Self { power: self.power.max(found), s }
    }

    /// Samples without it, if there is any.
    pub(crate) fn taken_out(&self, white: White<'_>) -> Vec<f64> {
        if self.is_some() { calmed(white, self.s.im / TAU).0 } else { white.samples.to_vec() }
    }

    /// Rows in which it hides that the forcing has gone, after the end of a forcing of which `free` is the
    /// decay.
    pub(crate) fn hides(&self, free: &Solution, step: f64) -> usize {
        let (a, size) = (-free.components[0].s.re * step, norm(&free.amplitudes[0]));
        (2.0 * self.power.sqrt() / (size * a)).min(0.1 / a).max(0.0) as usize
    }

    /// Whether there is any.
    pub(crate) fn is_some(&self) -> bool {
        self.power > 0.0
    }
}

fn norm(shape: &[C64]) -> f64 {
    shape.iter().map(C64::norm_sqr).sum::<f64>().sqrt()
}

/// Residuals without narrow noise, each channel over its deviation where that is larger than that of white
/// noise: a short silence may have less of it.
pub(crate) fn levelled(mut calm: Vec<f64>, channels: usize) -> Vec<f64> {
    for m in 0..channels {
        let own = || calm.iter().skip(m).step_by(channels);
        let deviation = (own().map(|v| v * v).sum::<f64>() / own().count().max(1) as f64).sqrt().max(1.0);
        calm.iter_mut().skip(m).step_by(channels).for_each(|v| *v /= deviation);
    }
    calm
}

/// Whether silence (hum taken out) rings at a frequency.
pub(crate) fn rings(silence: &[Vec<f64>], rate_hz: f64, mode_hz: f64) -> bool {
    let rows = silence.first().map_or(0, Vec::len);
    let apart = rate_hz / rows.max(1) as f64;
    if rows < 64 || 10.0 * apart > mode_hz {
        return false;
    }
    let mean = |offsets: &[f64]| {
        let of = |offset: &f64| -> f64 {
            let one = |y: &Vec<f64>| {
                let white = White { samples: y, channels: 1, step: rate_hz.recip() };
                loudness(white, 0, rows, mode_hz + offset * apart).powi(2)
            };
            silence.iter().map(one).sum()
        };
        offsets.iter().map(of).sum::<f64>() / offsets.len() as f64
    };
    mean(&NEAR) > RINGS * mean(&AWAY)
}

/// Samples of the stretches from which noise that rings a mode is taken out.
fn stretch(hz: f64, step: f64) -> usize {
    ((CALMED / (hz * step)).round() as usize).max(8)
}

/// Samples, row by row, without what is at one frequency over two periods at a time; and the energy that was
/// taken out of each such stretch.
pub(crate) fn calmed(white: White<'_>, hz: f64) -> (Vec<f64>, Vec<f64>) {
    let (mut left, channels) = (white.samples.to_vec(), white.channels);
    let span = stretch(hz, white.step);
    let mut energies = Vec::new();
    for part in left.chunks_mut(span * channels) {
        let rows = part.len() / channels;
        if rows < span {
            break;
        }
        let turn = C64::from_polar(1.0, -TAU * hz * white.step);
        let mut energy = 0.0;
        for m in 0..channels {
            let (mut phasor, mut sum) = (C64::ONE, C64::ZERO);
            for row in part.chunks_exact(channels) {
                sum += phasor * row[m];
                phasor *= turn;
            }
            let amplitude = sum * (2.0 / rows as f64);
            energy += 0.5 * amplitude.norm_sqr() * rows as f64;
            phasor = C64::ONE;
            for row in part.chunks_exact_mut(channels) {
                row[m] -= (amplitude * phasor.conj()).re;
                phasor *= turn;
            }
        }
        energies.push(energy);
    }
    (left, energies)
}

/// Twice the mean power at a frequency in white silence: that of a few decay times may be a half.
pub(crate) fn power_at(silence: White<'_>, hz: f64) -> f64 {
    let span = stretch(hz, silence.step) as f64;
    let (_, energies) = calmed(silence, hz);
    let mean = energies.iter().sum::<f64>() / energies.len().max(1) as f64;
    (TWICE * (2.0 * mean / span - 4.0 * silence.channels as f64 / span)).max(0.0)
}

/// Standard deviation of a channel's noise without what rings at a frequency.
pub(crate) fn calm_deviation(y: &[f64], rate_hz: f64, hz: f64) -> f64 {
    deviation(&calmed(White { samples: y, channels: 1, step: rate_hz.recip() }, hz).0)
}

/// Variance of residuals that [`calmed`] has made.
pub(crate) fn calm_variance(calm: &[f64], s: C64, step: f64) -> f64 {
    let span = stretch(s.im / TAU, step) as f64;
    dot(calm, calm) / calm.len().max(1) as f64 * span / (span - 2.0)
}

/// The row of residuals, the channel that has most of it, and the ratio of powers where the tone of the mode
/// is far louder than noise of the given power makes it.
pub(crate) fn beyond(left: White<'_>, s: C64, power: f64) -> Option<(usize, usize, f64)> {
    let hz = s.im / TAU;
    let span = stretch(hz, left.step);
    let (_, energies) = calmed(left, hz);
    let (k, most) = energies.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))?;
    let mean = 0.5 * power * span as f64 + 2.0 * left.channels as f64;
    let shares = tones(left, k * span, span, hz);
    let channel = (0..shares.len()).max_by(|&a, &b| shares[a].total_cmp(&shares[b]))?;
    (*most > 2.0 * CHANCE * mean).then_some((k * span, channel, most / mean))
}

/// Adds to the errors of a ping, of its drift and of its excesses of damping what noise of the given power,
/// which rings the mode, makes of them. Drift and excess then move what is independent of them.
pub(crate) fn widen(
    ping: &mut Ping,
    (drift, excess): (&mut Drift, &mut Excesses),
    power: f64,
    found: &Solution,
    rows: usize,
    step: f64,
) {
    let a = (-found.components[0].s.re).max(f64::MIN_POSITIVE);
    // The number and its variance, of a fit with a slope of this weight.
    let with = |value: f64, variance: f64, (slope, sd, moved): (f64, &mut f64, &mut f64), curve: &[f64]| {
        let known = if sd.is_finite() { *moved } else { 0.0 };
        let (own, of_curve) = covariance(power, found, rows, step, (known, curve));
        if !sd.is_finite() {
            return (value, variance + own);
        }
        // Of the number at the start, which the slope does not move, and of the slope.
        let square = sd.powi(2);
        let curved = square + of_curve[(1, 1)];
        let mixed = -*moved * square + of_curve[(0, 1)];
        let start = variance + moved.powi(2) * square + of_curve[(0, 0)];
        let (before, now) = (*moved, -mixed / curved);
        (*sd, *moved) = (curved.sqrt(), now);
        (value + (now - before) * slope, start - mixed * mixed / curved)
    };
    let weights = Drift::weights(a, rows, step);
    let of_drift = (drift.rate, &mut drift.sd, &mut drift.moment);
    (ping.s.im, ping.covariance[(1, 1)]) = with(ping.s.im, ping.covariance[(1, 1)], of_drift, &weights);
    let plain = (ping.s.re, ping.covariance[(0, 0)]);
    let [linear, square] = excess.each().map(|(x, law)| {
        let (weights, before) = (Excess::weights(a, rows, step, law), x.sd);
        let of_excess = (x.share, &mut x.sd, &mut x.moved);
        let found = with(plain.0 + x.plain, plain.1, of_excess, &weights);
        x.lose_support(before);
        found
    });
    (ping.s.re, ping.covariance[(0, 0)]) = linear;
    if excess.square.sd.is_finite() {
        excess.square.plain = square.0 - linear.0;
    }
}

/// sum over n and n' of f(n) g(n') keep^|n - n'|.
fn double_sum(f: &[f64], g: &[f64], keep: f64) -> f64 {
    let (mut sum, mut past_f, mut past_g) = (0.0, 0.0, 0.0);
    for (f, g) in f.iter().zip(g) {
        sum += f * g + g * past_f + f * past_g;
        past_f = keep * (past_f + f);
        past_g = keep * (past_g + g);
    }
    sum
}

/// Weights of the rows from `first` on in the growth rate (and frequency) of a fit that begins there; those
/// of the rows before are zero. Times xi/b.
fn weights(a: f64, rows: usize, first: usize, step: f64) -> Vec<f64> {
    let time = |n: usize| n as f64 * step;
    let (mut m0, mut m1, mut m2) = (0.0, 0.0, 0.0);
    for n in first..rows {
        let (t, w) = (time(n), (-2.0 * a * time(n)).exp());
        (m0, m1, m2) = (m0 + w, m1 + w * t, m2 + w * t * t);
    }
    let (middle, spread) = (m1 / m0, m2 - m1 * m1 / m0);
    (0..rows)
        .map(|n| if n < first { 0.0 } else { (time(n) - middle) * (-a * time(n)).exp() / spread })
        .collect()
}

/// Variance that noise of the power R puts on the difference of the growth rates of two fits, of which the
/// later one begins `later` rows after the other.
pub(crate) fn variance_of_difference(
    ringing: Ringing,
    found: &Solution,
    rows: usize,
    later: usize,
    step: f64,
) -> f64 {
    if !ringing.is_some() || later >= rows {
        return 0.0;
    }
    let a = (-found.components[0].s.re).max(f64::MIN_POSITIVE);
    let (early, late) = (weights(a, rows, 0, step), weights(a, rows, later, step));
    let difference: Vec<f64> = late.iter().zip(&early).map(|(l, e)| l - e).collect();
    0.5 * ringing.power / found.strength() * double_sum(&difference, &difference, (-a * step).exp())
}

/// Variance of growth rate and frequency, and covariance of (the same less `moved` times a slope, the slope),
/// that noise of the power R leaves in a fit of `rows` rows: the slope is a drift or an excess, whose weights
/// are given.
pub(crate) fn covariance(
    power: f64,
    found: &Solution,
    rows: usize,
    step: f64,
    (moved, curve): (f64, &[f64]),
) -> (f64, Matrix) {
    let a = (-found.components[0].s.re).max(f64::MIN_POSITIVE);
    let line = weights(a, rows, 0, step);
    let keep = (-a * step).exp();
    let scale = 0.5 * power / found.strength();
    let start: Vec<f64> = line.iter().zip(curve).map(|(l, c)| l - moved * c).collect();
    let mixed = double_sum(&start, curve, keep);
    let of_curve = [double_sum(&start, &start, keep), mixed, mixed, double_sum(curve, curve, keep)];
    let matrix = Matrix::from_fn(2, 2, |i, j| scale * of_curve[2 * i + j]);
    (scale * double_sum(&line, &line, keep), matrix)
}
