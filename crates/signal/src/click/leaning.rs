//! What an end reflects beyond the taps of the model, and how far times and gains lean on what is not known
//! of it.

use super::end::{flanged, unflanged};
use super::model::{Model, Rows, TAP_SPACING, TAPS};
use super::options::Reflection;
use super::segment::Segment;
use rijke_numerics::{C64, Matrix};
use std::f64::consts::TAU;

/// Frequencies at which reflections are compared; with 32 below 4 kHz their sum repeats after 8 ms.
const TONES: usize = 32;
/// By how much an infinite flange lengthens an end, in radii.
const LONGER: f64 = 0.8216 - 0.6133;
/// Share of the amplitude that an end may take beyond what it radiates: vortices at its edge, a grid.
const TAKEN: f64 = 0.02;

impl Model {
    /// The known reflection that overlaps the impulse; none if there is none, or if its lag is not known.
    fn known_end(&self) -> Option<&Reflection> {
        self.options.reflection.as_ref().filter(|_| !self.taps.is_empty() && self.pace_sd.is_none())
    }

    /// Sum of squared deviations of the taps of a known end from those expected, in standard deviations.
    pub(super) fn strangeness(&self) -> f64 {
        let Some(reflection) = self.known_end() else { return 0.0 };
        let sd = reflection.tolerance * reflection.strength;
        self.taps.iter().zip(&self.expected).map(|(tap, expected)| ((tap - expected) / sd).powi(2)).sum()
    }

    /// The record less what an unflanged end reflects of the impulse and the expected taps do not: its way
    /// with frequency, and the boundary layers between the microphone and the end, there and back, which
    /// differ from channel to channel. None if the end is not known.
    pub(super) fn without_rest(&self, raw: &Segment, rows: &Rows) -> Option<Segment> {
        let reflection = self.known_end()?;
        let taps = |omega: f64| -> C64 {
            let late = |j: usize| TAP_SPACING * (j as f64 - (TAPS / 2) as f64);
            self.expected.iter().enumerate().map(|(j, rho)| C64::from_polar(*rho, -omega * late(j))).sum()
        };
        let rest = |omega: f64, m: usize| {
            let end = unflanged(omega * reflection.smoothing) * reflection.strength.abs();
            taps(omega) - end * reflection.way(m, omega)
        };
        Some(self.with_echo(raw, rows, rest))
    }

    /// Error of each time (s) and relative error of each gain, signed, if the end is another one than the
    /// unflanged one that is expected: the answer of the fit, linear, to the difference of what they reflect.
    /// The ends are one that is only longer, by what an infinite flange adds, one with that flange, and one
    /// that takes [`TAKEN`].
    pub(super) fn leaning(&self, segment: &Segment, rows: &Rows, inverse: &Matrix) -> Vec<Vec<[f64; 2]>> {
        let channels = self.times.len();
        let Some(reflection) = self.known_end().filter(|_| self.options.leaning) else { return Vec::new() };
        let longer = |ka: f64| unflanged(ka) * C64::from_polar(1.0, -2.0 * ka * LONGER);
        let ends: [&dyn Fn(f64) -> C64; 3] = [&longer, &flanged, &|ka| (1.0 - TAKEN) * unflanged(ka)];
        let error = |end: &dyn Fn(f64) -> C64| -> Vec<[f64; 2]> {
            let difference = |omega: f64, m: usize| {
                let ka = omega * reflection.smoothing;
                (end(ka) - unflanged(ka)) * reflection.strength.abs() * reflection.way(m, omega)
            };
            let changed = self.with_echo(segment, rows, difference);
            // At the maximum of the likelihood the gradient of the record itself is zero.
            let answer = inverse.times(&self.linearise(&changed, rows).1);
            let own = |m: usize, free: usize| [answer[free], answer[channels - 1 + free] / self.gains[m]];
            (0..channels).map(|m| self.free(m).map_or([0.0; 2], |free| own(m, free))).collect()
        };
        ends.into_iter().map(error).collect()
    }

    /// The record and, where the reflection overlaps, the impulse through a filter: that of channel m at
    /// omega (rad/s) is `filter(omega, m)`, late by the lag of the reflection.
    fn with_echo(&self, segment: &Segment, rows: &Rows, filter: impl Fn(f64, usize) -> C64) -> Segment {
        let width = segment.highest_hz / TONES as f64;
        let tone = |k: usize| {
            let omega = TAU * width * (k as f64 + 0.5);
            (omega, 2.0 * width * self.waveform.transform(omega))
        };
        let tones: Vec<(f64, C64)> = (0..TONES).map(tone).collect();
        let mut changed = segment.clone();
        for (m, &(from, to)) in rows.iter().enumerate().filter(|(m, _)| self.options.overlaps(*m)) {
            let late = self.times[m] + self.options.lag(m).unwrap_or(0.0) - segment.time(from);
            // Each tone turns by the same angle from sample to sample.
            let step = segment.time(1) - segment.time(0);
            let mut turning: Vec<(C64, C64)> = tones
                .iter()
                .map(|(omega, w)| {
                    (
                        self.gains[m] * w * filter(*omega, m) * C64::from_polar(1.0, -omega * late),
                        C64::from_polar(1.0, omega * step),
                    )
                })
                .collect();
            for n in from..to {
                changed.add(m, n, turning.iter().map(|(value, _)| value.re).sum());
                turning.iter_mut().for_each(|(value, turn)| *value *= *turn);
            }
        }
        changed
    }
}

impl Reflection {
    /// What the way from microphone `m` to the end and back does to a tone at `omega`, rad/s, the lag left
    /// out.
    fn way(&self, m: usize, omega: f64) -> C64 {
        let root = self.dispersion.get(m).copied().unwrap_or(0.0) * omega.sqrt();
        C64::new(-root, -root).exp()
    }
}
