//! The parameters of a model that act as delays: a posterior may have a maximum in every period of each.

use crate::{Observed, PointModel};
use rijke_inference::{Parameter, Scan};
use rijke_network::{At, Laws};
use rijke_numerics::C64;
use std::f64::consts::TAU;

/// Turn of the wave, rad, in one step of a delay.
const TURN: f64 = 0.1;
/// A law that decays or bends by more than this in such a step is no wave of constant size.
const EXACT: f64 = 1e-6;
/// Searches over one period.
const PER_PERIOD: f64 = 5.0;
/// Quantile of the prior from which it is taken to reach to its mirror: four standard deviations.
const REACH: f64 = 3.167e-5;
/// Quantile at which the other parameters are held: not their middle, which may be a gain of zero.
const OTHERS: f64 = 0.7;

/// Those parameters in seconds of which every law is A + B exp(-i k tau) at the frequencies of the observed
/// modes, and whose prior reaches over more than half a period of the fastest of these.
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
        if p.unit != "s" || !wide.is_finite() || middle.iter().any(|v| !v.is_finite()) {
            return None;
        }
        let mut fastest = 0.0_f64;
        for (point, o) in points.iter().zip(observed) {
            fastest = fastest.max(rate(point, &middle, i, o.near.im)?);
        }
        let step = TAU / fastest / PER_PERIOD;
        (wide * fastest > 0.5 * TAU).then(|| Scan { parameter: p.name.clone(), step })
    };
    parameters.iter().enumerate().filter_map(of).collect()
}

/// By how much the laws turn per second of parameter `i` at s = i `omega`, rad/s: zero if they do not depend
/// on it, none if they do so in another way.
fn rate(point: &PointModel<'_>, values: &[f64], i: usize, omega: f64) -> Option<f64> {
    let step = TURN / omega;
    let at = |k: f64| {
        let mut moved = values.to_vec();
        moved[i] += k * step;
        let filled = point.filled(&moved).ok()?;
        let (at, mut laws) = (At::search(C64::new(0.0, omega)), Laws::default());
        laws.reset(filled.laws(), &at);
        filled.fill(&at, &mut laws);
        Some((0..filled.laws()).map(|k| laws.value(k)).collect::<Vec<_>>())
    };
    let values = [at(0.0)?, at(1.0)?, at(2.0)?, at(3.0)?];
    let mut fastest = 0.0_f64;
    for law in 0..values[0].len() {
        let change = |k: usize| values[k + 1][law] - values[k][law];
        if change(0).norm() <= EXACT * TURN * values[0][law].norm() {
            continue;
        }
        let turn = change(1) / change(0);
        let same = (change(2) / change(1) - turn).norm() < EXACT;
        if !same || (turn.norm() - 1.0).abs() > EXACT || turn.arg().abs() < EXACT.sqrt() {
            return None;
        }
        fastest = fastest.max(turn.arg().abs() / step);
    }
    Some(fastest)
}
