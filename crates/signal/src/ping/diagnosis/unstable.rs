//! Rigs that sound by themselves, so that no decay can be measured.

use super::{ALIKE, BESIDE, SPAN, STEADY, Whole};
use crate::error::Fault;
use crate::ping::verdict::loudness;
use crate::unstable::Unstable;
use std::ops::RangeInclusive;

/// Stretches in which a mode is seen to grow, by what factor in all, how clearly (slope of ln amplitude over
/// its standard deviation), and up to what frequency one is sought, Hz.
const GROWING: usize = 5;
const GROWN: f64 = 1.3;
const SURELY: f64 = 6.0;
const HIGHEST: f64 = 5000.0;
/// Share of its loudest moment from which a tone that is there before and after counts.
const HEARD: f64 = 0.2;

impl Whole<'_> {
    /// The loudest tone of the record, which is alike at its beginning and its end, steady there, not far
    /// below its loudest moment, and no hum.
    pub(super) fn by_itself(&self) -> Option<Fault> {
        let (white, frequency_hz) = (self.white(), self.loudest_hz);
        let end = white.rows().checked_sub(self.span)?;
        let before = end.checked_sub(2 * self.span)?;
        let [first, loudest, before, last] =
            [0, self.from, before, end].map(|row| self.size(row, frequency_hz));
        let mains_hz = self.options.mains_hz;
        let hum = (frequency_hz - (frequency_hz / mains_hz).round() * mains_hz).abs() < BESIDE;
        let same = |a: f64, b: f64, share: f64| (a - b).abs() < share * a.max(b);
        let alike =
            same(first, last, ALIKE) && same(before, last, STEADY) && first.min(last) > HEARD * loudest;
        (alike && !hum).then_some(Unstable::Oscillates { frequency_hz }.into())
    }

    /// The loudest tone of the record, if it grows until the end.
    pub(super) fn to_the_end(&self) -> Option<Fault> {
        let (rows, frequency_hz) = (self.white().rows(), self.loudest_hz);
        let last = rows.checked_sub(self.span)?;
        let (loudest, end) = (self.size(self.from, frequency_hz), self.size(last, frequency_hz));
        if loudest - end > ALIKE * loudest {
            return None;
        }
        self.growth(frequency_hz, rows / 2..=last).map(|_| Unstable::Grows { frequency_hz }.into())
    }

    /// The strongest tone beside the wanted mode at the end of the record, if it has grown since the loudest
    /// stretch.
    pub(super) fn growing(&self) -> Option<Fault> {
        let (white, span) = (self.white(), self.span);
        let last = white.rows().checked_sub(span)?;
        let step_hz = 0.5 / SPAN;
        let highest = (HIGHEST.min(0.45 * self.trace.rate_hz) / step_hz) as usize;
        let beside = |f: &f64| (f - self.loudest_hz).abs() > 2.0 / SPAN;
        let (_, frequency_hz) = (4..highest)
            .map(|k| k as f64 * step_hz)
            .filter(beside)
            .map(|f| (self.size(last, f), f))
            .max_by(|a, b| a.0.total_cmp(&b.0))?;
        let growth_rate = self.growth(frequency_hz, self.from + span..=last)?;
        Some(Unstable::Another { frequency_hz, growth_rate }.into())
    }

    /// Growth rate of a tone, 1/s, if it clearly grows over the stretches that begin in these rows: ln of its
    /// amplitude against time, by least squares over stretches that overlap by half.
    fn growth(&self, frequency_hz: f64, rows: RangeInclusive<usize>) -> Option<f64> {
        let step = (self.span / 2).max(1);
        let sizes: Vec<f64> = rows.step_by(step).map(|row| self.size(row, frequency_hz).ln()).collect();
        if sizes.len() < GROWING {
            return None;
        }
        let (slope, sd) = slope(&sizes);
        let clear = slope > SURELY * sd && slope * (sizes.len() - 1) as f64 > GROWN.ln();
        clear.then_some(slope * self.trace.rate_hz / step as f64)
    }

    /// Amplitude of a tone over all channels, in the stretch that begins at `row`.
    fn size(&self, row: usize, frequency_hz: f64) -> f64 {
        loudness(self.white(), row, self.span, frequency_hz)
    }
}

/// Slope per step of equally spaced numbers, by least squares, and its standard deviation.
fn slope(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let middle = 0.5 * (n - 1.0);
    let squares = n * (n * n - 1.0) / 12.0;
    let slope = values.iter().enumerate().map(|(k, v)| (k as f64 - middle) * v).sum::<f64>() / squares;
    let left = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() - slope * slope * squares;
    (slope, (left.max(0.0) / (n - 2.0) / squares).sqrt())
}
