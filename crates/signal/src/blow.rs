//! Several modes of a record that begins with a blow: a tube that was struck, and rings until it is silent.

use crate::random::live_length;
use crate::repeats::{Repeats, combine, pool};
use crate::ringdown::pencil::{Decimated, poles};
use crate::ringdown::{Component, Kind, SETTLING, Solution, White, energies, solve};
use crate::trace::clipped;
use crate::{Fault, Mishap};
use rijke_numerics::{C64, Matrix, median};
use std::f64::consts::TAU;

/// Settings of [`fit_blow`].
#[derive(Clone, Debug, PartialEq)]
pub struct BlowOptions {
    /// The stretch that is used, s after the onset.
    pub stretch_s: [f64; 2],
    /// The highest frequency that is looked at, Hz.
    pub highest_hz: f64,
    /// About where the wanted modes are, Hz.
    pub near_hz: Vec<f64>,
}

/// What a record of a blow tells.
#[derive(Clone, Debug, PartialEq)]
pub struct BlowFit {
    /// Onsets of blows, s from the first sample; the first is used.
    pub onsets_s: Vec<f64>,
    /// For every wanted frequency the mode, or none if none was found near it.
    pub modes: Vec<Option<BlowMode>>,
}

/// A mode.
#[derive(Clone, Debug, PartialEq)]
pub struct BlowMode {
    /// Growth rate and angular frequency, 1/s.
    pub s: C64,
    /// Covariance of the two.
    pub covariance: Matrix,
}

/// What several records of like blows tell together.
#[derive(Clone, Debug, PartialEq)]
pub struct CombinedBlows {
    /// For every wanted frequency the mean over the records, or none if no record has the mode.
    pub modes: Vec<Option<BlowMode>>,
    /// Records left out of the mean of a mode, by their place in the input, and why.
    pub outliers: Vec<(usize, Fault)>,
}

/// A blow begins where the envelope first reaches this part of its largest value.
const ONSET: f64 = 0.1;
/// Another begins where it rises by this factor over all of the 20 ms before.
const RISE: f64 = 3.0;
/// Length of a block of the envelope, s.
const BLOCK: f64 = 1e-3;
const BLOCKS_BEFORE: usize = 20;
/// The fit is made from several starts, so far apart, s: what the modes owe to the choice is part of their
/// error.
const LATER: f64 = 0.01;
const STARTS: usize = 3;
/// The first half of the stretch is louder than the second, in power, by so many deviations of white noise.
const LOUDER: f64 = 5.0;
/// A mode is one that was wanted if it is so near, relatively.
const NEAR: f64 = 0.04;

/// Finds the onset of the blow, and fits damped exponentials to the stretch behind it: the poles of ESPRIT,
/// then the maximum of the likelihood of all of them together, from several starts. Channels that are copies
/// of another count once, and the median of a channel is taken away first.
///
/// # Errors
/// [`Fault::Options`]; [`Fault::UnequalChannels`]; [`Fault::NotFinite`]; [`Fault::DeadChannel`] for a channel
/// of a single value; [`Fault::TooShort`] where the record or the stretch before another blow is too short;
/// [`Fault::Clipped`] for flat tops in the stretch; [`Mishap::NoBlow`] where it does not decay; faults of the
/// fits, if none of them succeeds.
pub fn fit_blow(channels: &[Vec<f64>], rate_hz: f64, options: &BlowOptions) -> Result<BlowFit, Fault> {
    let positive = |v: f64| v.is_finite() && v > 0.0;
    if !(positive(rate_hz) && positive(options.highest_hz)) {
        return Err(Fault::Options("the sampling rate or the highest frequency is no number above zero"));
    }
    if !(options.stretch_s[0] >= 0.0 && options.stretch_s[0] < options.stretch_s[1]) {
        return Err(Fault::Options("the stretch is not two times after the onset, the earlier one first"));
    }
    let have = live_length(channels)?;
    let mut own: Vec<Vec<f64>> = Vec::new();
    for channel in channels {
        let offset = median(channel.clone());
        let level: Vec<f64> = channel.iter().map(|v| v - offset).collect();
        if !own.contains(&level) {
            own.push(level);
        }
    }
    let onsets_s = onsets(&own, rate_hz);
    let first = onsets_s.first().copied().unwrap_or(0.0);
    // What follows another blow is another decay.
    let next = onsets_s.get(1).map_or(f64::INFINITY, |next| next - first);
    let [from, to] = [options.stretch_s[0], options.stretch_s[1].min(next)];
    let sample = |t: f64| ((first + t) * rate_hz).round() as usize;
    let (begin, end) = (sample(from), sample(to));
    if end > have || begin >= end {
        return Err(Fault::TooShort {
            what: "decay of the blow",
            have: have.min(end),
            need: sample(options.stretch_s[1]),
        });
    }
    let stretch: Vec<Vec<f64>> = own.iter().map(|c| c[begin..end].to_vec()).collect();
    if let Some(fault) = clipped(&stretch) {
        return Err(fault);
    }
    let factor = ((0.4 * rate_hz / options.highest_hz).floor() as usize).max(1);
    let mut found: Vec<Vec<BlowMode>> = vec![Vec::new(); options.near_hz.len()];
    let mut failed = None;
    for start in 0..STARTS {
        let begin = sample(from + LATER * start as f64).min(end);
        let samples: Vec<f64> = (begin..end).flat_map(|n| own.iter().map(move |c| c[n])).collect();
        let white = White { samples: &samples, channels: own.len(), step: 1.0 / rate_hz };
        let data = Decimated::new(white, factor);
        if start == 0 && !decays(data.white()) {
            let seconds = [first + from, first + to];
            return Err(Mishap::NoBlow { seconds, highest_hz: options.highest_hz }.into());
        }
        match fitted(&data, options) {
            Ok(modes) => {
                for (list, mode) in found.iter_mut().zip(modes) {
                    list.extend(mode);
                }
            }
            Err(fault) => failed = Some(fault),
        }
    }
    match failed {
        Some(fault) if found.iter().all(Vec::is_empty) => Err(fault),
        _ => Ok(BlowFit { onsets_s, modes: found.iter().map(|list| together(list)).collect() }),
    }
}

/// The mean of several records of like blows, mode by mode and with equal weights, as [`combine`] forms it of
/// repeats. How much records scatter is learnt from all modes together ([`pool`]).
#[must_use]
pub fn combine_blows(fits: &[BlowFit]) -> CombinedBlows {
    let count = fits.first().map_or(0, |f| f.modes.len());
    let mut outliers = Vec::new();
    let mut of = |k: usize| -> Option<Repeats> {
        let has = |(n, fit): (usize, &BlowFit)| Some((n, fit.modes.get(k)?.clone()?));
        let all: Vec<(usize, BlowMode)> = fits.iter().enumerate().filter_map(has).collect();
        let values: Vec<_> =
            all.iter().map(|(n, m)| (*n as f64, vec![m.s.re, m.s.im], m.covariance.clone())).collect();
        let hz = median(all.iter().map(|(_, m)| m.s.im / TAU).collect());
        let names = |i: usize| format!("{} of the mode at {hz:.1} Hz", ["growth rate", "frequency"][i]);
        let mut repeats = combine(&values, &names)?;
        outliers.extend(std::mem::take(&mut repeats.outliers).into_iter().map(|(i, why)| (all[i].0, why)));
        Some(repeats)
    };
    let mut found: Vec<Option<Repeats>> = (0..count).map(&mut of).collect();
    pool(&mut found.iter_mut().flatten().collect::<Vec<_>>());
    let mode = |r: Repeats| BlowMode { s: C64::new(r.mean[0], r.mean[1]), covariance: r.covariance };
    CombinedBlows { modes: found.into_iter().map(|r| r.map(mode)).collect(), outliers }
}

/// Whether the first half of a stretch is louder than the second.
fn decays(stretch: White<'_>) -> bool {
    let half = stretch.rows() / 2;
    let power = |from: usize| {
        let part = stretch.slice(from, from + half).samples;
        part.iter().map(|v| v * v).sum::<f64>()
    };
    // Decimated noise has some 0.8 independent numbers per sample; the ratio of two powers varies by sqrt(2)
    // times what one does.
    let freedom = 0.8 * (half * stretch.channels) as f64;
    power(0) > power(half) * (1.0 + LOUDER * 2.0 / freedom.sqrt())
}

/// The mean of at least two fits of one record from different starts, weighted by the errors of their
/// frequencies. They share most of their samples: its covariance is the mean of theirs and their scatter.
fn together(all: &[BlowMode]) -> Option<BlowMode> {
    if all.len() < 2 {
        return None;
    }
    let n = all.len() as f64;
    let weights: Vec<f64> = all.iter().map(|m| 1.0 / m.covariance[(1, 1)]).collect();
    let whole: f64 = weights.iter().sum();
    let mean: C64 = all.iter().zip(&weights).map(|(m, w)| m.s * *w).sum::<C64>() / whole;
    let apart = |m: &BlowMode| [(m.s - mean).re, (m.s - mean).im];
    let covariance = Matrix::from_fn(2, 2, |i, j| {
        let one = |(m, w): (&BlowMode, &f64)| {
            let scatter = apart(m)[i] * apart(m)[j] * n / (n - 1.0);
            w * (m.covariance[(i, j)] + scatter)
        };
        all.iter().zip(&weights).map(one).sum::<f64>() / whole
    });
    Some(BlowMode { s: mean, covariance })
}

/// Where blows begin, s.
fn onsets(channels: &[Vec<f64>], rate_hz: f64) -> Vec<f64> {
    let block = ((BLOCK * rate_hz).round() as usize).max(1);
    let length = channels.first().map_or(0, Vec::len);
    let size = |n: usize| channels.iter().map(|c| c[n].abs()).fold(0.0, f64::max);
    let envelope: Vec<f64> = (0..length)
        .step_by(block)
        .map(|n| (n..(n + block).min(length)).map(size).fold(0.0, f64::max))
        .collect();
    let least = ONSET * envelope.iter().copied().fold(0.0, f64::max);
    let mut all: Vec<usize> = Vec::new();
    for (k, value) in envelope.iter().enumerate().filter(|(_, value)| **value >= least) {
        let before = &envelope[k.saturating_sub(BLOCKS_BEFORE)..k];
        let is_apart = all.last().is_none_or(|last| k - last > BLOCKS_BEFORE);
        if all.is_empty() || (is_apart && *value > RISE * before.iter().copied().fold(0.0, f64::max)) {
            all.push(k);
        }
    }
    let first = |k: &usize| {
        let range = k * block..((k + 1) * block).min(length);
        range.clone().find(|n| size(*n) >= least).unwrap_or(range.start) as f64 / rate_hz
    };
    all.iter().map(first).collect()
}

/// The wanted modes of one stretch.
fn fitted(data: &Decimated, options: &BlowOptions) -> Result<Vec<Option<BlowMode>>, Fault> {
    let is_mode = |s: &C64| s.re < 0.0 && s.re > -0.5 * s.im && s.im < TAU * options.highest_hz;
    let list = poles(data)?;
    let mut components: Vec<Component> =
        list.into_iter().filter(is_mode).map(|s| Component::new(s, Kind::Mode)).collect();
    let solution: Solution = loop {
        let fault = match solve(data.white(), &components, SETTLING) {
            Ok(solution) => match solution.components.iter().position(|c| !is_mode(&c.s)) {
                None => break solution,
                Some(k) if components.len() > 1 => {
                    components.remove(k);
                    continue;
                }
                Some(_) => return Err(Fault::Weak(0.0)),
            },
            Err(fault) => fault,
        };
        if components.len() < 2 {
            return Err(fault);
        }
        let strength = energies(data.white(), &components)?;
        let weakest = (0..components.len()).min_by(|a, b| strength[*a].total_cmp(&strength[*b])).unwrap_or(0);
        components.remove(weakest);
    };
    let (strength, variance) = (solution.energies()?, solution.variance());
    let wanted = |near: &f64| {
        let is_near = |k: &usize| (solution.components[*k].s.im / (TAU * near) - 1.0).abs() < NEAR;
        let k = (0..solution.components.len())
            .filter(is_near)
            .max_by(|a, b| strength[*a].total_cmp(&strength[*b]))?;
        let whole = solution.mode_covariance(k);
        let covariance = Matrix::from_fn(2, 2, |i, j| variance * whole[(i, j)]);
        Some(BlowMode { s: solution.components[k].s, covariance })
    };
    Ok(options.near_hz.iter().map(wanted).collect())
}
