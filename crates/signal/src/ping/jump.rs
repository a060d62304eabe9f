//! Whether a decay jumps: samples that the acquisition lost, or a kick too weak to be seen in the residuals.
//!
//! From some moment on the amplitude of all channels is 1 + e times what the decay before says, e complex. To
//! first order the residuals hold e b_m e^{st} from there on. Of this step counts only what is at right
//! angles, under e^{2 sigma t}, to 1 and t, which the fit has taken out; or also to t^2 and t^3, so that
//! neither a drift of the frequency nor damping that depends on the amplitude is taken for a jump. Every row
//! is tried. Terms at twice the frequency are left out, and so are the neighbours, as in [`super::chirp`].

use crate::ringdown::Solution;
use crate::{Fault, Mishap};
use rijke_numerics::{C64, Cholesky, Matrix};
use std::f64::consts::TAU;

/// Twice the logarithm of the likelihood that a jump must gain: of white noise, which has a dozen moments of
/// its own in a decay, one ping in a million gains so much.
pub(super) const CLEAR: f64 = 33.0;
/// By how much it must gain more than what else explains a decay.
pub(super) const BETTER: f64 = 12.0;
/// Decay times after the start of a fit before which no jump is looked for, and periods: what is left of a
/// loudspeaker acts there.
const FIRST: f64 = 0.3;
const PERIODS: f64 = 3.0;
/// The least and the largest part of the amplitude by which a decay that jumps is refused. Sound records show
/// smaller jumps; larger ones are seen in the residuals, and the first order does not describe them.
const SIZES: [f64; 2] = [0.01, 0.25];
/// Part of a sample by which a jump may miss a whole number of them, and deviations.
const WHOLE: f64 = 0.2;
const DEVIATIONS: f64 = 4.0;
/// Part of the turn of the phase by which the size may differ, too: the fit of the whole decay has taken up
/// some of the jump.
const TAKEN_UP: f64 = 0.1;
/// Part of a step that must be left behind smooth changes; less is rounding.
const ROUNDING: f64 = 1e-6;

/// Powers of t that are no jump.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Smooth {
    /// 1 and t.
    Fitted = 2,
    /// Up to the third one.
    Cubic = 4,
}

/// A jump of the amplitude of the first component.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Jump {
    /// The first row behind it.
    pub(super) row: usize,
    /// By how much it lessens the sum of squares of the residuals.
    pub(super) gain: f64,
    /// The amplitude of all channels behind it over what it would be.
    ratio: C64,
    /// Information on the real and on the imaginary part, for unit noise.
    information: f64,
}

impl Jump {
    /// The jump that explains most of the residuals `left` of a fit; none if it is no small one, or
    /// the decay too short.
    pub(super) fn of(found: &Solution, left: &[f64], step: f64, smooth: Smooth) -> Option<Self> {
        let (amplitudes, powers) = (&found.amplitudes[0], smooth as usize);
        let (s, rows) = (found.components[0].s, left.len() / amplitudes.len().max(1));
        let (wave, decay) = (found.wave(rows, step), -s.re * step);
        // Sums over all rows from a row on: of the weight times powers of t, and of what is left.
        let mut behind = vec![([0.0; 4], C64::ZERO); rows + 1];
        let (mut gram, mut seen) = (Matrix::zeros(powers, powers), [C64::ZERO; 4]);
        for n in (0..rows).rev() {
            let wave = C64::new(wave.re[n], wave.im[n]);
            let row = &left[n * amplitudes.len()..(n + 1) * amplitudes.len()];
            let score = (row.iter().zip(amplitudes).map(|(r, b)| b * *r).sum::<C64>() * wave).conj();
            let (weight, t) = (wave.norm_sqr(), decay * n as f64);
            let t = [1.0, t, t * t, t * t * t];
            let (mut sums, total) = behind[n + 1];
            for i in 0..powers {
                sums[i] += weight * t[i];
                seen[i] += score * t[i];
                for j in 0..powers {
                    gram[(i, j)] += weight * t[i] * t[j];
                }
            }
            behind[n] = (sums, total + score);
        }
        let inverse = Cholesky::new(&gram).ok()?.inverse();
        let strength = 0.5 * found.strength();
        let at = |row: usize| {
            let (sums, total) = &behind[row];
            let taken = inverse.times(&sums[..powers]);
            let spread = sums[0] - taken.iter().zip(sums).map(|(a, b)| a * b).sum::<f64>();
            let score = taken.iter().zip(&seen).fold(*total, |score, (a, b)| score - b * *a);
            let information = strength * spread;
            let told = spread > ROUNDING * sums[0];
            let gain = if told { score.norm_sqr() / information } else { 0.0 };
            Self { row, gain, ratio: 1.0 + score / information, information }
        };
        let first = (FIRST / decay).max(PERIODS * TAU / (s.im * step)) as usize;
        let best = (first..rows).map(at).max_by(|a, b| a.gain.total_cmp(&b.gain));
        best.filter(|jump| (SIZES[0]..SIZES[1]).contains(&(jump.ratio - 1.0).norm()))
    }

    /// What it is in a decay `s`, at a time, s, for the variance of the noise.
    pub(super) fn fault(&self, s: C64, at: f64, step: f64, variance: f64) -> Fault {
        let sd = (variance / self.information).sqrt();
        let (turn, ln) = (s.im * step, self.ratio.ln());
        let (samples, whole) = (ln.im / turn, (ln.im / turn).round());
        let is_whole = (samples - whole).abs() < WHOLE && sd < WHOLE * turn;
        let has_faded_as_much =
            (ln.re - s.re * step * whole).abs() < DEVIATIONS * sd + TAKEN_UP * ln.im.abs();
        if whole != 0.0 && is_whole && has_faded_as_much {
            let (samples, seconds, frequency_hz) = (whole as isize, whole * step, s.im / TAU);
            return Mishap::LostSamples { at, samples, seconds, frequency_hz }.into();
        }
        Mishap::Jumps { at, factor: self.ratio.norm(), degrees: ln.im.to_degrees() }.into()
    }
}
