//! Samples that a decay lacks, or holds twice: a buffer that ran over.
//!
//! From one moment on every channel then shows what the decay before that moment says, so many samples later
//! (or earlier). One whole number has to do this for all modes and all channels: neither a loudspeaker that
//! acts again nor a rig that changes does so. A frequency that drifts moves the phase little by little; the
//! best jump leaves a fourteenth of what its t^2 adds, and one that is a jump leaves noise.

use super::backwards::explains;
use super::forcing::Envelope;
use super::search::Search;
use super::verdict::phasors;
use crate::Mishap;
use crate::ringdown::{SEARCHING, Solution, White};
use rijke_numerics::C64;
use std::f64::consts::TAU;

/// The first stretch of the decay that is fitted, s, by how much the next one is longer, and the longest.
const FIRST: f64 = 0.05;
const LONGER: f64 = 1.3;
const LONGEST: f64 = 0.6;
/// Length over which the decay after the jump is compared with that before it, s.
const AFTER: f64 = 0.03;
/// Power over that of the noise that the decay before must leave of what follows, and what it may leave of it
/// as it would be so many samples later: of the noise, and of the power.
const CLEAR: f64 = 16.0;
const NOISE: f64 = 1.5;
const LEFT: f64 = 0.02;
/// Share that may be left of the power of a single channel.
const OF_ONE: f64 = 0.1;
/// Periods that may have been held twice, and lost.
const PERIODS: (i32, i32) = (-4, 20);
/// Samples by which the phase of the mode may mislead.
const BESIDE: isize = 2;

/// A jump of all channels in the decay, whose first row comes at `begin`, s.
pub(super) fn lost(
    search: &Search<'_>,
    white: White<'_>,
    envelope: &Envelope,
    begin: f64,
    order: usize,
) -> Option<Mishap> {
    let rows = |seconds: f64| (seconds / white.step).ceil() as usize;
    let from = envelope.safe_start();
    let (known, broken) = before(search, white, envelope, from)?;
    let mode = known.components[0].s;
    let frequency_hz = mode.im / TAU;
    let after = rows(AFTER).max(4 * envelope.block);
    let (at, to) = (from + broken, (from + broken + after).min(white.rows()));
    if to < at + 2 * envelope.block {
        return None;
    }
    let part = white.slice(at, to);
    let left = known.residuals(part, broken as f64);
    let said: Vec<f64> = part.samples.iter().zip(&left).map(|(y, left)| y - left).collect();
    let said = White { samples: &said, ..part };
    let [heard, said] = [part, said].map(|white| phasors(white, 0, white.rows(), frequency_hz));
    let turn: C64 = heard.iter().zip(&said).map(|(a, b)| a * b.conj()).sum();
    let power = |samples: isize| {
        let left = known.residuals(part, broken as f64 + samples as f64);
        left.iter().map(|v| v * v).sum::<f64>()
    };
    let period = 1.0 / (frequency_hz * white.step);
    let whole = |k: i32| (period * (turn.arg() / TAU + f64::from(k))).round() as isize;
    let tried = (PERIODS.0..=PERIODS.1).flat_map(|k| (-BESIDE..=BESIDE).map(move |d| whole(k) + d));
    let tried = tried.filter(|n| *n != 0 && broken as f64 + *n as f64 > 0.0);
    let (samples, _) = tried.map(|n| (n, power(n))).min_by(|a, b| a.1.total_cmp(&b.1))?;
    let row = jump(&known, white.slice(from, at), samples);
    let behind = white.slice(from + row + order, to);
    let squares = |shift: isize| -> Vec<f64> {
        let left = known.residuals(behind, (row + order) as f64 + shift as f64);
        let of = |m: usize| left.iter().skip(m).step_by(white.channels).map(|v| v * v).sum::<f64>();
        (0..white.channels).map(|m| of(m) / behind.rows().max(1) as f64).collect()
    };
    let (without, with) = (squares(0), squares(samples));
    let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
    let all = mean(&without) > CLEAR && mean(&with) < NOISE + LEFT * mean(&without);
    let each = without.iter().zip(&with).all(|(a, b)| *a < CLEAR || *b < NOISE + OF_ONE * a);
    let at = begin + (from + row) as f64 * white.step;
    (all && each).then_some(Mishap::LostSamples {
        at,
        samples,
        seconds: samples as f64 * white.step,
        frequency_hz,
    })
}

/// A fit of the longest stretch from `from` on that modes explain, and the length of one that they do not.
fn before(
    search: &Search<'_>,
    white: White<'_>,
    envelope: &Envelope,
    from: usize,
) -> Option<(Solution, usize)> {
    let (mut known, mut length) = (None, (FIRST / white.step).max(10.0 * envelope.block as f64));
    while length * white.step < LONGEST {
        let to = from + length as usize;
        if to > white.rows() {
            return None;
        }
        let window = white.slice(from, to);
        let guess = search.first_guess(window).ok();
        let found = guess.and_then(|(list, _)| search.solve(window, window, list, SEARCHING).ok());
        match found.filter(|found| explains(search, window, found)) {
            Some(found) => known = Some(found),
            None => return known.map(|known| (known, length as usize)),
        }
        length *= LONGER;
    }
    None
}

/// The row of a stretch, from the first one of the fit on, from which it is that of so many samples later.
fn jump(known: &Solution, stretch: White<'_>, samples: isize) -> usize {
    // Before the first sample nothing was fitted.
    let skipped = samples.min(0).unsigned_abs();
    let stretch = stretch.slice(skipped, stretch.rows());
    let squares = |shift: isize| -> Vec<f64> {
        let left = known.residuals(stretch, skipped as f64 + shift as f64);
        left.chunks_exact(stretch.channels).map(|row| row.iter().map(|v| v * v).sum()).collect()
    };
    let (mut sum, mut least, mut row) = (0.0, 0.0, 0);
    for (n, (without, with)) in squares(0).iter().zip(squares(samples)).enumerate() {
        sum += without - with;
        if sum < least {
            (least, row) = (sum, n + 1);
        }
    }
    skipped + row
}
