//! The noise of a record: colour of each channel, correlation between channels, mains hum.
//!
//! A prediction-error filter turns a damped exponential into the same exponential with another amplitude, so
//! a record can be whitened before the fit and the amplitudes corrected after it, both exactly.

use super::kernels::{Powers, add_scaled, add_scaled_inline, dot, run};
use super::mains::mains_of;
use crate::Fault;
use pulp::NullaryFnOnce;
use rijke_numerics::{C64, Cholesky, Matrix};

/// Highest order of a prediction-error filter. White noise with 1/f below about 30 Hz needs 3 to 8 at 10 kHz.
const MAX_ORDER: usize = 12;
/// Periods of a tone over which a channel's mean is taken away where its pressure wanders. A whole number
/// leaves the tone as it is.
const WANDER: f64 = 3.0;
/// Samples whitened at a time: those of eight channels stay close to the processor.
const BLOCK: usize = 256;
/// Highest harmonic of the mains that is looked for.
pub(crate) const MAX_HARMONIC: u32 = 8;

/// Turns the noise of a record into white noise of unit variance, independent between channels.
#[derive(Clone, Debug)]
pub(crate) struct Whitener {
    /// One prediction-error filter per channel, leading 1, all of the same length.
    filters: Vec<Vec<f64>>,
    /// Lower Cholesky factor of the covariance of the filtered channels.
    lower: Matrix,
    /// Its inverse, row by row.
    inverse: Matrix,
}

impl Whitener {
    /// Learns the noise from samples that hold nothing else (hum already subtracted).
    pub(crate) fn learn(noise: &[Vec<f64>]) -> Result<Self, Fault> {
        let mut filters: Vec<Vec<f64>> = noise.iter().map(|y| prediction_error_filter(y)).collect();
        let length = filters.iter().map(Vec::len).max().unwrap_or(1);
        for filter in &mut filters {
            filter.resize(length, 0.0);
        }
        let channels = noise.len();
        let unmixed =
            Self { filters, lower: Matrix::identity(channels), inverse: Matrix::identity(channels) };
        let white = unmixed.apply(noise, 0, noise.first().map_or(0, Vec::len));
        let mut covariance = Matrix::zeros(channels, channels);
        for row in white.chunks_exact(channels) {
            for i in 0..channels {
                for j in 0..=i {
                    covariance[(i, j)] += row[i] * row[j];
                }
            }
        }
        let count = (white.len() / channels.max(1)).max(1) as f64;
        let lower = Cholesky::new(&Matrix::from_fn(channels, channels, |i, j| {
            covariance[(i.max(j), i.min(j))] / count
        }))?
        .lower()
        .clone();
        let inverse = invert_lower(&lower);
        Ok(Self { filters: unmixed.filters, lower, inverse })
    }

    /// Noise taken as white, with the given standard deviation in each channel.
    pub(crate) fn scaling(deviations: &[f64]) -> Self {
        let reciprocal: Vec<f64> = deviations.iter().map(|d| d.recip()).collect();
        Self {
            filters: vec![vec![1.0]; deviations.len()],
            lower: Matrix::diagonal(deviations),
            inverse: Matrix::diagonal(&reciprocal),
        }
    }

    /// The same after each channel has lost its mean over [`WANDER`] periods of a tone: what is slower than
    /// that, a wandering pressure or a drifting amplifier, goes, and the tone stays as it is. The filter is
    /// longer by these periods.
    pub(crate) fn without_wander(&self, tone_hz: f64, rate_hz: f64) -> Self {
        let length = (WANDER * rate_hz / tone_hz).round() as usize;
        let mut kernel = vec![-1.0 / length as f64; length];
        kernel[length / 2] += 1.0;
        let convolved = |filter: &Vec<f64>| {
            let mut all = vec![0.0; filter.len() + length - 1];
            for (k, a) in filter.iter().enumerate() {
                all[k..k + length].iter_mut().zip(&kernel).for_each(|(sum, b)| *sum += a * b);
            }
            all
        };
        Self { filters: self.filters.iter().map(convolved).collect(), ..self.clone() }
    }

    /// Number of samples at the start of a stretch that the filter uses up.
    pub(crate) fn order(&self) -> usize {
        self.filters.first().map_or(0, |f| f.len() - 1)
    }

    /// White samples, one row of channels per sample, for samples `from + order .. to`.
    pub(crate) fn apply(&self, channels: &[Vec<f64>], from: usize, to: usize) -> Vec<f64> {
        let rows = to.saturating_sub(from + self.order());
        let mut white = vec![0.0; rows * self.filters.len()];
        run(Whiten { whitener: self, channels, from, white: &mut white });
        white
    }

    /// The matrix U and its derivative in s with: amplitudes in the record = U(s) amplitudes in the white
    /// samples.
    pub(crate) fn unwhiten(&self, s: C64, step: f64) -> (Vec<Vec<C64>>, Vec<C64>) {
        let count = self.filters.len();
        let mut matrix = vec![vec![C64::ZERO; count]; count];
        let mut log_slopes = vec![C64::ZERO; count];
        let delay = (-s * step).exp();
        for (m, filter) in self.filters.iter().enumerate() {
            let (mut gain, mut slope, mut delayed) = (C64::ZERO, C64::ZERO, C64::ONE);
            for (j, &a) in filter.iter().enumerate() {
                gain += a * delayed;
                slope -= j as f64 * step * a * delayed;
                delayed *= delay;
            }
            for n in 0..=m {
                matrix[m][n] = self.lower[(m, n)] / gain;
            }
            log_slopes[m] = -slope / gain;
        }
        (matrix, log_slopes)
    }

    /// The matrix W(s) with: amplitudes in the white samples = W(s) amplitudes in the record.
    pub(crate) fn whiten(&self, s: C64, step: f64) -> Vec<Vec<C64>> {
        let (count, delay) = (self.filters.len(), (-s * step).exp());
        let gain = |filter: &Vec<f64>| filter.iter().rev().fold(C64::ZERO, |sum, &a| sum * delay + a);
        let gains: Vec<C64> = self.filters.iter().map(gain).collect();
        (0..count).map(|i| (0..count).map(|m| self.inverse[(i, m)] * gains[m]).collect()).collect()
    }

    /// Standard deviation of white noise that would have the density of each channel's noise at frequency
    /// `omega`.
    pub(crate) fn deviations(&self, omega: f64, step: f64) -> Vec<f64> {
        self.filters
            .iter()
            .enumerate()
            .map(|(m, filter)| {
                let gain: C64 = filter
                    .iter()
                    .enumerate()
                    .map(|(j, &a)| C64::from_polar(a, -omega * step * j as f64))
                    .sum();
                let variance: f64 = self.lower.row(m).iter().map(|v| v * v).sum();
                variance.sqrt() / gain.norm()
            })
            .collect()
    }
}

struct Whiten<'a> {
    whitener: &'a Whitener,
    channels: &'a [Vec<f64>],
    from: usize,
    white: &'a mut [f64],
}

impl NullaryFnOnce for Whiten<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Whitener { filters, inverse, .. } = self.whitener;
        let (order, count) = (self.whitener.order(), filters.len());
        let (mut filtered, mut mixed) = (vec![[0.0; BLOCK]; count], [0.0; BLOCK]);
        for (block, out) in self.white.chunks_mut(BLOCK * count).enumerate() {
            let (first, length) = (self.from + order + block * BLOCK, out.len() / count);
            for ((filter, y), filtered) in filters.iter().zip(self.channels).zip(&mut filtered) {
                filtered.fill(0.0);
                for (lag, &a) in filter.iter().enumerate() {
                    add_scaled_inline(filtered, a, &y[first - lag..first - lag + length]);
                }
            }
            for i in 0..count {
                mixed.fill(0.0);
                for (&a, filtered) in inverse.row(i)[..=i].iter().zip(&filtered) {
                    add_scaled_inline(&mut mixed, a, filtered);
                }
                for (out, value) in out[i..].iter_mut().step_by(count).zip(&mixed) {
                    *out = *value;
                }
            }
        }
    }
}

/// The prediction-error filter of a stationary series by the Levinson recursion on its autocovariance, its
/// order chosen by Schwarz's criterion: a filter longer than needed costs samples at the start of the decay.
fn prediction_error_filter(y: &[f64]) -> Vec<f64> {
    let n = y.len();
    let order = MAX_ORDER.min(n / 20);
    let covariance: Vec<f64> = (0..=order).map(|lag| dot(y, &y[lag..]) / n as f64).collect();
    let mut filter = vec![1.0];
    let mut power = covariance[0];
    let mut best = (n as f64 * power.ln(), filter.clone());
    for p in 1..=order {
        let error: f64 = filter.iter().enumerate().map(|(j, a)| a * covariance[p - j]).sum();
        let reflection = -error / power;
        filter.push(0.0);
        let reversed: Vec<f64> = filter.iter().rev().copied().collect();
        for (a, r) in filter.iter_mut().zip(reversed) {
            *a += reflection * r;
        }
        power *= 1.0 - reflection * reflection;
        let criterion = n as f64 * power.ln() + (n as f64).ln() * p as f64;
        if criterion < best.0 {
            best = (criterion, filter.clone());
        }
    }
    best.1
}

/// Inverse of a lower triangular matrix.
pub(crate) fn invert_lower(lower: &Matrix) -> Matrix {
    let n = lower.rows();
    let mut inverse = Matrix::zeros(n, n);
    for j in 0..n {
        for i in j..n {
            let known: f64 = (j..i).map(|k| lower[(i, k)] * inverse[(k, j)]).sum();
            inverse[(i, j)] = (f64::from(u8::from(i == j)) - known) / lower[(i, i)];
        }
    }
    inverse
}

/// Harmonics of the mains that stand out of a stretch of noise, found and subtracted in place, but for those
/// that are `left` there.
///
/// `mains_hz` is the nominal frequency: over half a second its drift by 0.1 Hz costs 1 % of the subtraction.
/// From a longer stretch the frequency itself is learnt ([`mains_of`]). Returns the numbers of the harmonics.
pub(crate) fn remove_hum(noise: &mut [Vec<f64>], rate_hz: f64, mains_hz: f64, left: &[u32]) -> Vec<u32> {
    let mut present = Vec::new();
    for y in noise.iter_mut() {
        let mean = y.iter().sum::<f64>() / y.len() as f64;
        y.iter_mut().for_each(|v| *v -= mean);
    }
    let length = noise.first().map_or(0, Vec::len);
    if length == 0 || (length as f64) < 3.0 * rate_hz / mains_hz {
        return present;
    }
    let highest = MAX_HARMONIC.min((0.4 * rate_hz / mains_hz) as u32);
    let mains_hz = mains_of(noise, rate_hz, mains_hz, highest, left);
    let wave = |hz: f64| Powers::new(C64::from_polar(1.0, std::f64::consts::TAU * hz / rate_hz), length);
    // Lines that are there do not count as noise beside the others.
    let mut calm = noise.to_vec();
    for harmonic in 1..=highest {
        let wave = wave(f64::from(harmonic) * mains_hz);
        let amplitudes = tone(&calm, &wave);
        calm.iter_mut().zip(amplitudes).for_each(|(y, a)| take_away(y, a, &wave));
    }
    for harmonic in (1..=highest).filter(|h| !left.contains(h)) {
        let wave = wave(f64::from(harmonic) * mains_hz);
        let amplitudes: Vec<C64> = tone(noise, &wave);
        // Each term is chi-squared with two degrees of freedom if the noise is white. Noise of a flow is
        // louder at low frequencies: what lies beside the harmonic counts where it is more than white noise
        // would have.
        let beside = level_beside(&calm, rate_hz, f64::from(harmonic) * mains_hz, mains_hz);
        let strength: f64 = noise
            .iter()
            .zip(&amplitudes)
            .zip(beside)
            .map(|((y, a), beside)| {
                let variance = (dot(y, y) / length as f64).max(beside);
                0.5 * a.norm_sqr() * length as f64 / variance
            })
            .sum();
        let freedom = 2.0 * noise.len() as f64;
        if strength > freedom + 2.5 * (2.0 * freedom).sqrt() {
            present.push(harmonic);
            noise.iter_mut().zip(amplitudes).for_each(|(y, a)| take_away(y, a, &wave));
        }
    }
    present
}

fn take_away(y: &mut [f64], a: C64, wave: &Powers) {
    add_scaled(y, -a.re, &wave.re);
    add_scaled(y, a.im, &wave.im);
}

/// Frequencies on each side of a harmonic, in units of what a stretch resolves, that tell of the noise there.
const BESIDE: [f64; 4] = [1.5, 2.5, 3.5, 4.5];

/// Variance that white noise would have which is as loud as each of `noise` is beside a frequency: up to half
/// of the distance to the next harmonic away.
fn level_beside(noise: &[Vec<f64>], rate_hz: f64, hz: f64, mains_hz: f64) -> Vec<f64> {
    let length = noise.first().map_or(0, Vec::len);
    let away = BESIDE.map(|k| k * rate_hz / length.max(1) as f64);
    let away = away.iter().enumerate().filter(|(k, away)| *k == 0 || **away < 0.5 * mains_hz);
    let beside: Vec<f64> = away.flat_map(|(_, away)| [hz - away, hz + away]).collect();
    let mut levels = vec![0.0; noise.len()];
    for hz in &beside {
        let wave = Powers::new(C64::from_polar(1.0, std::f64::consts::TAU * hz / rate_hz), length);
        for (level, y) in levels.iter_mut().zip(noise) {
            let sum = C64::new(dot(y, &wave.re), -dot(y, &wave.im));
            *level += sum.norm_sqr() / (length * beside.len()) as f64;
        }
    }
    levels
}

/// Frequencies of mains, Hz.
const GRIDS: [f64; 2] = [50.0, 60.0];
/// Power of a line over that beside it from which it is one, and from which a second harmonic bears it out.
const LINE: f64 = 25.0;
const BORNE_OUT: f64 = 10.0;
/// A stated frequency this near, relative, is the same.
const SAME: f64 = 0.04;

/// The frequency of mains, Hz, with which the first `quiet` samples hum, if that is not the stated one and
/// louder: a line with one of its next two multiples, each above what lies beside it. Shorter than ten
/// periods, silence does not tell.
pub(crate) fn other_mains(channels: &[Vec<f64>], quiet: usize, rate_hz: f64, stated_hz: f64) -> Option<f64> {
    let apart = rate_hz / quiet.max(1) as f64;
    let power = |f: f64| {
        let of = |y: &Vec<f64>| {
            let part = &y[..quiet.min(y.len())];
            let mean = part.iter().sum::<f64>() / part.len() as f64;
            let (turn, mut phasor) = (C64::from_polar(1.0, -std::f64::consts::TAU * f / rate_hz), C64::ONE);
            let around = std::f64::consts::TAU / part.len() as f64;
            let (mut sum, mut squares) = (C64::ZERO, 0.0);
            for (n, v) in part.iter().enumerate() {
                sum += phasor * ((1.0 - (around * (n as f64 + 0.5)).cos()) * (v - mean));
                squares += (v - mean) * (v - mean);
                phasor *= turn;
            }
            if squares > 0.0 { sum.norm_sqr() / squares } else { 0.0 }
        };
        channels.iter().map(of).sum::<f64>()
    };
    let line = |f: f64| {
        let mut beside = [-4.5, -3.5, -2.5, 2.5, 3.5, 4.5].map(|k| power(f + k * apart));
        beside.sort_by(f64::total_cmp);
        power(f) / beside[2].max(f64::MIN_POSITIVE)
    };
    let hums = |f: &f64| {
        (f / stated_hz - 1.0).abs() > SAME
            && 10.0 * apart < *f
            && 3.0 * f < 0.4 * rate_hz
            && power(*f) > 4.0 * power(stated_hz)
            && line(*f) > LINE
            && line(2.0 * f).max(line(3.0 * f)) > BORNE_OUT
    };
    GRIDS.into_iter().find(hums)
}

/// Least-squares complex amplitude a of Re(a z^n) in each series, for the powers z^n given.
pub(crate) fn tone(series: &[Vec<f64>], wave: &Powers) -> Vec<C64> {
    let (cc, cs, ss) = (dot(&wave.re, &wave.re), -dot(&wave.re, &wave.im), dot(&wave.im, &wave.im));
    let determinant = cc * ss - cs * cs;
    let amplitude = |y: &Vec<f64>| {
        let (yc, ys) = (dot(y, &wave.re), -dot(y, &wave.im));
        C64::new((ss * yc - cs * ys) / determinant, (cc * ys - cs * yc) / determinant)
    };
    series.iter().map(amplitude).collect()
}
