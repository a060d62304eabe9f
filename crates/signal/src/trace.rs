//! A multichannel record as plain data, and what can be said against it before any fit.

use crate::Fault;
use crate::dsp::kernels::{LANES, run};
use pulp::NullaryFnOnce;
use rijke_numerics::{Cholesky, Matrix};
use rijke_rig::Record;

/// One multichannel record. Borrowed, so that any source of samples will do.
#[derive(Clone, Copy, Debug)]
pub struct Trace<'a> {
    /// Samples of each channel; all channels have the same length. Any unit.
    pub channels: &'a [Vec<f64>],
    /// Sampling rate, Hz.
    pub rate_hz: f64,
    /// The first `quiet` samples hold noise only.
    pub quiet: usize,
    /// Samples of this size or more are clipped; infinity if the limit is not known (flat tops are then
    /// looked for).
    pub full_scale: f64,
}

/// An offset of this share of the deviation of silence is taken away; fits do not feel a smaller one.
const OFFSET: f64 = 0.3;
/// Means of two stretches that agree within this share of them are one offset.
const AGREES: f64 = 0.35;
/// Coefficients of the polynomial that takes the place of an offset that drifts.
const TREND: usize = 5;
/// Stretches of the record that count by their own noise.
const STRETCHES: usize = 100;
/// This many equal samples in a row are a dropout, but for a converter whose steps are larger than the noise.
const DROPOUT: usize = 24;
/// A converter is that coarse if this share of successive samples of silence, or of the end of the record,
/// are equal: noise of half a step.
const EQUAL: f64 = 0.45;
/// And if a channel spans at most so many steps.
const LEVELS: f64 = 4096.0;
/// A clipped level has so many times the samples of the one beside it: a sine has 2.4 times.
const PILED: usize = 4;
/// A channel of steps of the converter, whose samples span less than this share of the median channel, is
/// missing.
const SILENCE: f64 = 1e-3;
/// This many equal samples in a row at the extreme value of a channel are a flat top.
const FLAT_TOP: usize = 4;

impl<'a> From<&'a Record> for Trace<'a> {
    fn from(record: &'a Record) -> Self {
        Self {
            channels: &record.channels,
            rate_hz: record.rate_hz,
            quiet: record.quiet,
            full_scale: record.full_scale,
        }
    }
}

impl Trace<'_> {
    /// Number of samples per channel.
    #[must_use]
    pub fn len(&self) -> usize {
        self.channels.first().map_or(0, Vec::len)
    }

    /// Whether there are no samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The channels less their offsets, such as an amplifier's; none if no offset is worth it. An offset
    /// whose mean at the end of the record differs from that of the quiet part by more than a share of the
    /// noise drifts: a polynomial takes its place. A constant one is the mean of the quiet part, or, if that
    /// has fewer than `least` samples, of the last tenth of the record. Slow noise is no offset: the quarters
    /// of that stretch, and the last tenth, must agree.
    pub(crate) fn levelled(&self, least: usize) -> Option<Vec<Vec<f64>>> {
        let (all, quiet) = (self.len(), self.quiet.min(self.len()));
        let tail = all - all / 10..all;
        let still = if quiet >= least.max(4) { 0..quiet } else { tail.clone() };
        let mean = |y: &[f64]| y.iter().sum::<f64>() / y.len().max(1) as f64;
        let offset = |y: &Vec<f64>| {
            let (still, tail) =
                (y.get(still.clone()).unwrap_or_default(), y.get(tail.clone()).unwrap_or_default());
            let level = mean(still);
            let deviation =
                (still.iter().map(|v| (v - level).powi(2)).sum::<f64>() / still.len().max(1) as f64).sqrt();
            let agrees = |part: &[f64]| (mean(part) - level).abs() < AGREES * level.abs();
            let constant = still.chunks(still.len().div_ceil(4).max(1)).chain([tail]).all(agrees);
            if constant && level.abs() > OFFSET * deviation { level } else { 0.0 }
        };
        let drifts = |y: &Vec<f64>, step: f64| {
            let (start, end) =
                (y.get(still.clone()).unwrap_or_default(), y.get(tail.clone()).unwrap_or_default());
            // What still rings at the end has a mean, too.
            let noise = about_a_line(start).max(about_a_line(end)).sqrt().max(step);
            quiet >= least.max(4) && (mean(end) - mean(start)).abs() > OFFSET * noise
        };
        let less = |(y, step): (&Vec<f64>, f64)| match drifts(y, step).then(|| trend(y)).flatten() {
            Some(trend) => Some(y.iter().zip(trend).map(|(v, t)| v - t).collect()),
            None => Some(offset(y)).filter(|o| *o != 0.0).map(|o| y.iter().map(|v| v - o).collect()),
        };
        let levelled: Vec<Option<Vec<f64>>> =
            self.channels.iter().zip(self.coarse_steps()).map(less).collect();
        let whole = |(level, y): (Option<Vec<f64>>, &Vec<f64>)| level.unwrap_or_else(|| y.clone());
        levelled
            .iter()
            .any(Option::is_some)
            .then(|| levelled.into_iter().zip(self.channels).map(whole).collect())
    }

    /// Refuses a record whose samples cannot be right: unequal lengths, numbers that are not finite, clipped,
    /// missing or interrupted channels. `need` is the shortest record that the caller can use.
    ///
    /// # Errors
    /// The first [`Fault`] found.
    pub fn screen(&self, need: usize) -> Result<(), Fault> {
        let have = self.len();
        if have < need.max(1) {
            return Err(Fault::TooShort { what: "record", have, need: need.max(1) });
        }
        let mut extremes = Vec::with_capacity(self.channels.len());
        for (channel, samples) in self.channels.iter().enumerate() {
            if samples.len() != have {
                return Err(Fault::UnequalChannels {
                    channel: channel.into(),
                    have: samples.len(),
                    need: have,
                });
            }
            let look = run(Look(samples));
            if !look.finite
                && let Some(sample) = samples.iter().position(|y| !y.is_finite())
            {
                return Err(Fault::NotFinite { channel: channel.into(), sample });
            }
            extremes.push(look);
        }
        let mut spans: Vec<f64> = extremes.iter().map(|e| e.high - e.low).collect();
        spans.sort_by(f64::total_cmp);
        let median = spans[spans.len() / 2];
        for (channel, (samples, extremes)) in self.channels.iter().zip(extremes).enumerate() {
            self.screen_channel(channel, samples, extremes, median)?;
        }
        for (second, samples) in self.channels.iter().enumerate() {
            if let Some(first) = self.channels[..second].iter().position(|other| other == samples) {
                return Err(Fault::SameChannels(first.into(), second.into()));
            }
        }
        Ok(())
    }

    /// The step of the converter in each channel, where it is so coarse that equal samples follow in rows; 0
    /// in the others.
    pub(crate) fn coarse_steps(&self) -> Vec<f64> {
        let of = |y: &Vec<f64>| if run(Look(y)).repeats && self.is_coarse(y) { step(y) } else { 0.0 };
        self.channels.iter().map(of).collect()
    }

    /// Whether equal samples follow in rows because the steps of the converter are larger than the noise.
    fn is_coarse(&self, y: &[f64]) -> bool {
        let still = |part: &[f64]| {
            let equal = part.windows(2).filter(|pair| pair[0] == pair[1]).count();
            equal as f64 > EQUAL * part.len() as f64
        };
        let quiet = y.get(..self.quiet).filter(|part| part.len() >= DROPOUT).is_some_and(still);
        let range = y.iter().fold(0.0_f64, |a, v| a.max((v - y[0]).abs()));
        (quiet || still(&y[y.len() - y.len() / 10..])) && range < LEVELS * step(y)
    }

    fn screen_channel(
        &self,
        channel: usize,
        samples: &[f64],
        Extremes { low, high, repeats, .. }: Extremes,
        median: f64,
    ) -> Result<(), Fault> {
        let span = high - low;
        if span == 0.0 {
            return Err(Fault::DeadChannel { channel: channel.into(), span, median });
        }
        let limit = self.full_scale * (1.0 - 1e-6);
        if !repeats && high < limit && low > -limit {
            return Ok(());
        }
        let mut at_limit = 0;
        let (mut run, mut run_start) = (1, 0);
        for (n, &y) in samples.iter().enumerate() {
            at_limit += usize::from(y.abs() >= limit);
            if n > 0 && y == samples[n - 1] {
                run += 1;
            } else {
                (run, run_start) = (1, n);
            }
            if run == DROPOUT && span < SILENCE * median {
                return Err(Fault::DeadChannel { channel: channel.into(), span, median });
            }
            if run == DROPOUT && y != low && y != high && !self.is_coarse(samples) {
                let length = samples[run_start..].iter().take_while(|&&v| v == y).count();
                return Err(Fault::Dropout {
                    channel: channel.into(),
                    at: run_start as f64 / self.rate_hz,
                    samples: length,
                });
            }
        }
        if at_limit > 0 {
            return Err(Fault::Clipped {
                channel: channel.into(),
                samples: at_limit,
                level: self.full_scale,
            });
        }
        if let Some((samples, level)) = flat_top(samples, low, high) {
            return Err(Fault::Clipped { channel: channel.into(), samples, level });
        }
        Ok(())
    }
}

/// How many samples sit at an extreme value of a channel whose tops are flat, and the value.
fn flat_top(samples: &[f64], low: f64, high: f64) -> Option<(usize, f64)> {
    [low, high].into_iter().find_map(|level| {
        let mut run = 0;
        let tops = samples.iter().any(|y| {
            run = if *y == level { run + 1 } else { 0 };
            run == FLAT_TOP
        });
        if !tops {
            return None;
        }
        let step = step(samples);
        let beside = if level == low { low + step } else { high - step };
        let count = samples.iter().filter(|&&y| y == level).count();
        let near = samples.iter().filter(|&&y| (y - beside).abs() < 0.5 * step).count();
        (count >= PILED * near).then_some((count, level))
    })
}

/// The first channel whose tops are flat, as those of a channel that reached its limit.
pub(crate) fn clipped(channels: &[Vec<f64>]) -> Option<Fault> {
    channels.iter().enumerate().find_map(|(channel, samples)| {
        let Extremes { low, high, .. } = run(Look(samples));
        let (samples, level) = flat_top(samples, low, high)?;
        Some(Fault::Clipped { channel: channel.into(), samples, level })
    })
}

/// The polynomial of least squares through a channel, of the degree that a drifting offset has. Sound has
/// hundreds of periods in a record and hardly enters it; loud stretches count less.
fn trend(y: &[f64]) -> Option<Vec<f64>> {
    let half = 0.5 * (y.len() as f64 - 1.0);
    let powers = |n: usize| {
        let t = (n as f64 - half) / half;
        std::array::from_fn::<f64, TREND, _>(|k| t.powi(k as i32))
    };
    let (mut normal, mut data) = (Matrix::zeros(TREND, TREND), vec![0.0; TREND]);
    let block = (y.len() / STRETCHES).max(1);
    for (k, stretch) in y.chunks(block).enumerate() {
        let weight = about_a_line(stretch).max(f64::MIN_POSITIVE).recip();
        for (n, v) in stretch.iter().enumerate() {
            let row = powers(k * block + n);
            for i in 0..TREND {
                data[i] += weight * row[i] * v;
                for j in 0..TREND {
                    normal[(i, j)] += weight * row[i] * row[j];
                }
            }
        }
    }
    let coefficients = Cholesky::new(&normal).ok()?.inverse().times(&data);
    let at = |n: usize| powers(n).iter().zip(&coefficients).map(|(p, c)| p * c).sum();
    Some((0..y.len()).map(at).collect())
}

/// Mean square about the straight line through a stretch: an offset that drifts is not loud.
pub(crate) fn about_a_line(y: &[f64]) -> f64 {
    let n = y.len().max(1) as f64;
    let middle = 0.5 * (n - 1.0);
    let mean = y.iter().sum::<f64>() / n;
    let time = |k: usize| k as f64 - middle;
    let squares = n * (n * n - 1.0) / 12.0;
    let slope = y.iter().enumerate().map(|(k, v)| time(k) * v).sum::<f64>() / squares.max(1.0);
    y.iter().enumerate().map(|(k, v)| (v - mean - slope * time(k)).powi(2)).sum::<f64>() / n
}

/// The smallest difference of successive samples that are not equal: the step of a converter.
fn step(y: &[f64]) -> f64 {
    let steps = y.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|d| *d > 0.0);
    steps.fold(f64::INFINITY, f64::min)
}

/// What one quick look at a channel tells.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Extremes {
    low: f64,
    high: f64,
    /// Whether three successive samples are equal anywhere.
    repeats: bool,
    finite: bool,
}

struct Look<'a>(&'a [f64]);

impl NullaryFnOnce for Look<'_> {
    type Output = Extremes;

    #[inline(always)]
    fn call(self) -> Extremes {
        let y = self.0;
        let (mut low, mut high) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
        // Zero times a number that is not finite is no number.
        let (mut zero, mut repeats) = ([0.0; LANES], [0_u64; LANES]);
        let count = y.len().saturating_sub(2);
        let chunks = y.chunks_exact(LANES).zip(y.get(1..).unwrap_or_default().chunks(LANES));
        let thirds = y.get(2..).unwrap_or_default().chunks_exact(LANES);
        for ((a, b), c) in chunks.zip(thirds) {
            for i in 0..LANES {
                low[i] = if a[i] < low[i] { a[i] } else { low[i] };
                high[i] = if a[i] > high[i] { a[i] } else { high[i] };
                zero[i] += 0.0 * a[i];
                repeats[i] |= u64::from((a[i] == b[i]) & (b[i] == c[i]));
            }
        }
        let done = count / LANES * LANES;
        for (n, &v) in y.iter().enumerate().skip(done) {
            low[0] = v.min(low[0]);
            high[0] = v.max(high[0]);
            zero[0] += 0.0 * v;
            repeats[0] |= u64::from(n >= 2 && y[n - 2] == y[n - 1] && y[n - 1] == v);
        }
        Extremes {
            low: low.into_iter().fold(f64::INFINITY, f64::min),
            high: high.into_iter().fold(f64::NEG_INFINITY, f64::max),
            repeats: repeats.iter().any(|r| *r > 0),
            finite: zero.iter().all(|z| *z == 0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oracle_the_quick_look_sees_what_a_slow_one_does() {
        for count in [1, 2, 3, 9, 10, 11, 40] {
            for place in 0..count {
                let mut y: Vec<f64> = (0..count).map(|n| f64::from((n * 7 % 11) as u8) - 4.5).collect();
                y[place] = 20.0;
                let look = run(Look(&y));
                let (low, high) = y.iter().fold((0.0_f64, 0.0_f64), |e, v| (v.min(e.0), v.max(e.1)));
                assert!(look.low == low.max(-4.5) || count < 9, "{look:?} {low}");
                assert!(look.high == high && look.finite && !look.repeats, "{look:?}");
                if place + 2 < count {
                    (y[place + 1], y[place + 2]) = (20.0, 20.0);
                    assert!(run(Look(&y)).repeats, "{place} of {count}");
                }
                y[place] = f64::NAN;
                assert!(!run(Look(&y)).finite);
                y[place] = f64::NEG_INFINITY;
                assert!(!run(Look(&y)).finite);
            }
        }
    }
}
