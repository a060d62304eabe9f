//! When the loudspeaker has come to rest: a fit of a free decay does not depend on where it begins.

use super::ringing::variance_of_difference;
use super::search::Search;
use super::slope::{Curve, seen};
use crate::ringdown::{SETTLING, Solution, White, glance};
use rijke_numerics::C64;

/// How much later the fits begin with which the first one is compared, s: a loudspeaker comes to rest within
/// some milliseconds.
const LATER: [f64; 2] = [0.006, 0.02];
/// Share of the decay that a later fit must keep.
const KEPT: f64 = 0.5;
/// Distance by which the start is moved on at a time, s, and how often.
const MOVE: f64 = 0.002;
const MOVES: usize = 12;
/// Distance by which a start that was moved on is moved on at last, s: two times what a loudspeaker takes
/// that comes to rest with 3 ms.
const FURTHER: f64 = 0.006;
/// Deviations of the difference beyond which fits disagree (chance does this to one pair in forty), and those
/// at which a start that cannot be moved on any more refuses the record.
const DISAGREE: f64 = 2.24;
const REFUSED: f64 = 4.5;
/// Share of [`DISAGREE`] below which one step says that fits agree, and no fit is made.
const ALIKE: f64 = 0.75;
/// Share of the first fit's covariance that is added to that of a difference: neighbours may be fitted in one
/// fit alone.
const SLACK: f64 = 0.05;
/// Times with which a loudspeaker comes to rest, s, that are looked for.
const AT_REST: [f64; 2] = [0.001, 0.003];
/// Square of the amplitude over the variance of one of its parts beyond which a loudspeaker dies away. By
/// chance, exp(-DIES/2) = 5 % of the records exceed it, for each of these times.
const DIES: f64 = 6.0;

/// Two fits of one decay that disagree.
pub(crate) struct Disagreement {
    /// Rows from which they were made.
    pub(crate) rows: [usize; 2],
    pub(crate) growth_rates: [f64; 2],
    /// Difference over its standard deviation.
    pub(crate) distance: f64,
}

/// The fit and its first row, moved on until fits that begin later agree with it. Of two fits, one of which
/// has all rows of the other, the covariance of the difference is the difference of the covariances.
pub(crate) fn at_rest(
    search: &Search<'_>,
    white: White<'_>,
    (first, to): (usize, usize),
    need: usize,
    mut found: Solution,
) -> Result<(usize, Solution), Disagreement> {
    let rows = |seconds: f64| (seconds / white.step).ceil() as usize;
    let refit = |from: usize, known: &Solution| {
        let part = white.slice(from, to);
        search.solve(part, part, known.components.clone(), SETTLING).ok()
    };
    let mut from = first;
    for moves in 0.. {
        let half = rows(0.5 / -found.components[0].s.re.min(-f64::MIN_POSITIVE)).min((to - from) / 2);
        let least = (need / 2).max((KEPT * (to - from) as f64) as usize);
        let away = |later: usize| {
            let start = from + later;
            let narrow = variance_of_difference(search.ringing, &found, to - from, later, white.step);
            if start + least > to || agrees(search, white.slice(start, to), &found, narrow) {
                return None;
            }
            let late = refit(start, &found)?;
            let growth_rates = [found.components[0].s.re, late.components[0].s.re];
            Some(Disagreement {
                rows: [from, start],
                growth_rates,
                distance: distance(&found, &late, narrow),
            })
        };
        let later = [rows(LATER[0]), rows(LATER[1]), half];
        let disagrees = |later: &usize| away(*later).is_some_and(|w| w.distance > DISAGREE);
        let dies = || !search.ringing.is_some() && dying(white.slice(from, to), &found) > DIES;
        if !later.iter().any(disagrees) && !dies() {
            break;
        }
        let next = from + rows(MOVE);
        match refit(next, &found) {
            Some(later) if moves < MOVES && next + need <= to => (from, found) = (next, later),
            _ => {
                let all = later.into_iter().filter_map(away);
                match all.max_by(|a, b| a.distance.total_cmp(&b.distance)) {
                    Some(worst) if worst.distance > REFUSED => return Err(worst),
                    _ => break,
                }
            }
        }
    }
    // What is left of a loudspeaker that was still moving then is too little to be seen, and up to half a
    // standard deviation: it falls by a further factor.
    let (next, moved) = (from + rows(FURTHER), from > first);
    let later = if moved && next + need <= to { refit(next, &found) } else { None };
    Ok(later.map_or((from, found), |later| (next, later)))
}

/// What is left at the start of a fit and dies away as a loudspeaker does that comes to rest: the square of
/// its complex amplitude over the variance of a part of it. It has the shape of the mode.
fn dying(part: White<'_>, found: &Solution) -> f64 {
    let (rows, step) = (part.rows(), part.step);
    let left = found.residuals(part, 0.0);
    let (decay, amplitudes, wave) = (-found.components[0].s.re, &found.amplitudes[0], found.wave(rows, step));
    let of = |time: f64| {
        let curve = Curve::of(time.recip(), decay, rows, step);
        let score = seen(&left, amplitudes, &wave, |n| curve.values[n]);
        score.norm_sqr() / (0.5 * found.strength() * curve.spread * found.variance())
    };
    AT_REST.into_iter().map(of).fold(0.0, f64::max)
}

/// Difference of two growth rates over its standard deviation. A frequency may drift.
fn distance(early: &Solution, late: &Solution, narrow: f64) -> f64 {
    apart(early, late.components[0].s, late.covariance[(0, 0)], narrow)
}

/// The same from the first frequency of the later fit, the variance of its growth rate, for unit noise, and
/// that of the difference which noise that rings the mode adds.
fn apart(early: &Solution, late: C64, variance: f64, narrow: f64) -> f64 {
    let difference = late.re - early.components[0].s.re;
    let variance = variance - (1.0 - SLACK) * early.covariance[(0, 0)];
    // The later fit may have fewer neighbours than the earlier one: nothing can be said then.
    if variance > 0.0 { difference.abs() / (early.variance() * variance + narrow).sqrt() } else { 0.0 }
}

/// Whether one step from the fit `early` towards that of a later `part` stays so short that a fit would not
/// disagree. Not where the step would end a neighbour: the fit would be one of other components.
fn agrees(search: &Search<'_>, part: White<'_>, early: &Solution, narrow: f64) -> bool {
    glance(part, &early.components).is_ok_and(|late| {
        search.are_modes(&late.components)
            && apart(early, late.components[0].s, late.variance, narrow) < ALIKE * DISAGREE
    })
}
