//! The parameters of a model that act as delays: a posterior may have a maximum in every period of each.

use crate::{Observed, PointModel};
use rijke_inference::{Parameter, Scan};
use rijke_network::{At, Laws};
use rijke_numerics::C64;
use std::f64::consts::TAU;

/// Turn of the wave, rad, in one step of a delay.
const TURN: f64 = 0.1;
/// A trial step, which tells how fast the laws turn, as a share of the reach of the prior.
const FIRST: f64 = 1e-4;
/// Change of a law in the trial step, as a share of itself, and turn, rad, below which both are rounding.
const CHANGED: f64 = 1e-9;
const LEAST: f64 = 1e-5;
/// A law that decays or bends by more than this in such a step is no wave of constant size.
const EXACT: f64 = 1e-6;
/// Searches over one period.
const PER_PERIOD: f64 = 5.0;
/// Quantile of the prior from which it is taken to reach to its mirror: four standard deviations.
const REACH: f64 = 3.167e-5;
/// Quantile at which the other parameters are held: not their middle, which may be a gain of zero.
const OTHERS: f64 = 0.7;

/// Those parameters of which every law is A + B exp(-i k v) at the frequencies of the observed modes, and
/// whose prior reaches over more than half a period of the fastest of these: a delay, or what a delay is
/// proportional to, as a length over a velocity.
pub(crate) fn delays(
    points: &[PointModel<'_>],
    observed: &[Observed],
    parameters: &[Parameter],
) -> Vec<Scan> {
    let of = |(i, p): (usize, &Parameter)| {
        let wide = p.prior.quantile(1.0 - REACH) - p.prior.quantile(REACH);
        let middle: Vec<f64> = parameters
            .iter()
            .enumerate()
            .map(|(k, q)| q.prior.quantile(if k == i { 0.5 } else { OTHERS }))
            .collect();
        if !wide.is_finite() || middle.iter().any(|v| !v.is_finite()) {
            return None;
        }
        let mut fastest = 0.0_f64;
        for (point, o) in points.iter().zip(observed) {
            fastest = fastest.max(rate(point, &middle, (i, FIRST * wide), o.near.im)?);
        }
        let step = TAU / fastest / PER_PERIOD;
        (wide * fastest > 0.5 * TAU).then(|| Scan { parameter: p.name.clone(), step })
    };
    parameters.iter().enumerate().filter_map(of).collect()
}

/// By how much the laws turn per unit of parameter `i` at s = i `omega`, rad/s: zero if they do not depend on
/// it, none if they do so in another way. `first` is a trial step of it.
fn rate(point: &PointModel<'_>, values: &[f64], (i, first): (usize, f64), omega: f64) -> Option<f64> {
    let at = |change: f64| {
        let mut moved = values.to_vec();
        moved[i] += change;
        let filled = point.filled(&moved).ok()?;
        let (at, mut laws) = (At::search(C64::new(0.0, omega)), Laws::default());
        laws.reset(filled.laws(), &at);
        filled.fill(&at, &mut laws);
        Some((0..filled.laws()).map(|k| laws.value(k)).collect::<Vec<_>>())
    };
    let here = at(0.0)?;
    let changes = |step: f64| {
        let there = [at(step)?, at(2.0 * step)?, at(3.0 * step)?];
        let change = |law: usize| {
            [there[0][law] - here[law], there[1][law] - there[0][law], there[2][law] - there[1][law]]
        };
        Some((0..here.len()).map(change).collect::<Vec<_>>())
    };
    let roughly = changes(first)?;
    let moved: Vec<usize> =
        (0..here.len()).filter(|&law| roughly[law][0].norm() > CHANGED * here[law].norm()).collect();
    if moved.is_empty() {
        return Some(0.0);
    }
    let turn = |[a, b, _]: &[C64; 3]| (b / a).arg().abs();
    let most = moved.iter().map(|&law| turn(&roughly[law])).fold(0.0, f64::max);
    if most < LEAST {
        return None;
    }
    let step = first * TURN / most;
    let exactly = changes(step)?;
    let mut fastest = 0.0_f64;
    for law in moved {
        let [a, b, c] = exactly[law];
        if a.norm() <= EXACT * TURN * here[law].norm() {
            continue;
        }
        let turn = b / a;
        let same = (c / b - turn).norm() < EXACT;
        if !same || (turn.norm() - 1.0).abs() > EXACT || turn.arg().abs() < EXACT.sqrt() {
            return None;
        }
        fastest = fastest.max(turn.arg().abs() / step);
    }
    Some(fastest)
}
