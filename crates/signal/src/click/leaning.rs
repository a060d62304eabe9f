//! How far the times and gains of a click lean on the model of its reflection.

use super::end::unflanged;
use super::model::{Model, Rows, TAP_SPACING, TAPS};
use super::segment::Segment;
use rijke_numerics::{C64, Matrix};
use std::f64::consts::TAU;

/// Frequencies at which reflections are compared; with 32 below 4 kHz their sum repeats after 8 ms.
const TONES: usize = 32;

impl Model {
    /// Error of each time (s) and relative error of each gain if the far end is that of an unflanged pipe:
    /// the answer of the fit, linear, to the difference between what such an end reflects of the impulse and
    /// what the expected taps do.
    pub(super) fn leaning(&self, segment: &Segment, rows: &Rows, inverse: &Matrix) -> Vec<[f64; 2]> {
        let channels = self.times.len();
        let mut errors = vec![[0.0; 2]; channels];
        let Some(reflection) = &self.options.reflection else { return errors };
        if self.taps.is_empty() || self.pace_sd.is_some() {
            return errors;
        }
        let width = segment.highest_hz / TONES as f64;
        let tones: Vec<(f64, C64)> = (0..TONES)
            .map(|k| {
                let omega = TAU * width * (k as f64 + 0.5);
                let turn = |t: f64| C64::from_polar(1.0, -omega * t);
                let tap = |(j, rho): (usize, &f64)| *rho * turn(TAP_SPACING * (j as f64 - (TAPS / 2) as f64));
                let taps: C64 = self.expected.iter().enumerate().map(tap).sum();
                let end = unflanged(omega * reflection.smoothing) * reflection.strength.abs();
                (omega, 2.0 * width * self.waveform.transform(omega) * (end - taps))
            })
            .collect();
        let mut changed = segment.clone();
        for (m, &(from, to)) in rows.iter().enumerate().filter(|(m, _)| self.options.overlaps(*m)) {
            for n in from..to {
                let t = segment.time(n) - self.times[m] - reflection.lags[m];
                let more: f64 = tones.iter().map(|(omega, a)| (a * C64::from_polar(1.0, omega * t)).re).sum();
                changed.add(m, n, self.gains[m] * more);
            }
        }
        // At the maximum of the likelihood the gradient of the record itself is zero.
        let answer = inverse.times(&self.linearise(&changed, rows).1);
        for (m, error) in errors.iter_mut().enumerate() {
            *error = self.free(m).map_or([0.0; 2], |free| {
                [answer[free].abs(), (answer[channels - 1 + free] / self.gains[m]).abs()]
            });
        }
        errors
    }
}
