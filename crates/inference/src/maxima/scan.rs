//! Starts for parameters in which a model nearly repeats itself: each is moved over its prior, and the others
//! are fitted.

use super::terrain::latin;
use crate::density::{Calls, Method, TrustRegion, minimise};
use crate::fit::{Conditional, Posterior};
use rayon::prelude::*;
use rijke_numerics::{Order, Streams};

/// A parameter in which a posterior may have many maxima, of about the same width: a delay.
#[derive(Clone, Debug, PartialEq)]
pub struct Scan {
    /// Its name.
    pub parameter: String,
    /// Between values of which a search from the nearest finds a maximum, in the parameter's unit: a fifth of
    /// a period.
    pub step: f64,
}

/// How far a scan of one parameter goes, prior standard deviations: as far as images of a maximum are
/// looked at.
const REACH: f64 = 8.0;
/// How far a scan of several goes: twice as far it would be four times as coarse.
const REACH_OF_SEVERAL: f64 = 4.0;
/// Most points of a scan. Where a grid over several parameters has more, this many are spread over them.
const MOST: usize = 1200;
/// Most points from which a search starts.
const KEPT: usize = 16;
/// Points closer than this to a better one, in steps of every parameter, are left out.
const NEAR: f64 = 1.5;
/// Turns of parameters and noise at one point, and evaluations of each turn.
const TURNS: usize = 3;
const EVALUATIONS: usize = 12;
/// Drop in J, nats, at which a turn ends.
const ROUGH: f64 = 0.5;
/// Nats within which the noise of a turn is the best one.
const REFINED: f64 = 0.02;

/// A point of a scan with the other parameters fitted: its values of the scanned ones, J, and all parameters.
struct Fitted {
    at: Vec<f64>,
    cost: f64,
    parameters: Vec<f64>,
}

impl Posterior<'_> {
    /// The most probable points (physical parameters) of a scan over the prior, and what they cost; none
    /// without `scans`, or if a prior is improper.
    pub(crate) fn scanned(&self, scans: &[Scan], streams: Streams) -> (Vec<Vec<f64>>, Calls) {
        let parameters = self.parameters();
        // A parameter that an earlier stage knows to half a period has one maximum.
        let wide = |&(i, step): &(usize, f64)| {
            let [low, high] = self.reach(i, REACH_OF_SEVERAL);
            high - low > 2.5 * step
        };
        let axes: Vec<(usize, f64)> = scans
            .iter()
            .filter_map(|s| Some((parameters.index(&s.parameter)?, s.step)))
            .filter(wide)
            .collect();
        if axes.is_empty() || parameters.improper().is_some() {
            return (Vec::new(), Calls::default());
        }
        let held: Vec<usize> = axes.iter().map(|(i, _)| *i).collect();
        let tried: Vec<(Option<Fitted>, Calls)> = self
            .points(&axes, streams)
            .into_par_iter()
            .map(|at| {
                let mut calls = Calls::default();
                (self.fitted_at(&held, at, &mut calls), calls)
            })
            .collect();
        let calls = tried.iter().fold(Calls::default(), |sum, (_, calls)| sum.plus(*calls));
        let mut found: Vec<Fitted> = tried.into_iter().filter_map(|(fitted, _)| fitted).collect();
        found.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        let near = |a: &Fitted, b: &Fitted| {
            a.at.iter().zip(&b.at).zip(&axes).all(|((a, b), (_, step))| (a - b).abs() < NEAR * step)
        };
        // Of neighbours the best, or a scan along a ridge would keep one place alone.
        let best = (0..found.len()).filter(|&k| !found[..k].iter().any(|better| near(better, &found[k])));
        (best.take(KEPT).map(|k| found[k].parameters.clone()).collect(), calls)
    }

    /// Values of the scanned parameters, physical: a grid, or a Latin hypercube where that is too large.
    fn points(&self, axes: &[(usize, f64)], streams: Streams) -> Vec<Vec<f64>> {
        let sds = if axes.len() == 1 { REACH } else { REACH_OF_SEVERAL };
        let reaches: Vec<[f64; 2]> = axes.iter().map(|(i, _)| self.reach(*i, sds)).collect();
        let counts: Vec<usize> = reaches
            .iter()
            .zip(axes)
            .map(|([low, high], (_, step))| ((high - low) / step).ceil().clamp(1.0, MOST as f64) as usize + 1)
            .collect();
        let between = |k: usize, share: f64| reaches[k][0] + share * (reaches[k][1] - reaches[k][0]);
        let total = counts.iter().try_fold(1_usize, |total, n| total.checked_mul(*n));
        let Some(total) = total.filter(|total| *total <= MOST) else {
            let inside = |cube: Vec<f64>| cube.iter().enumerate().map(|(k, u)| between(k, *u)).collect();
            return latin(MOST, axes.len(), streams, 0).into_iter().map(inside).collect();
        };
        let one = |mut number: usize| {
            let place = |(k, n): (usize, &usize)| {
                let share = (number % n) as f64 / (n - 1) as f64;
                number /= n;
                between(k, share)
            };
            counts.iter().enumerate().map(place).collect()
        };
        (0..total).map(one).collect()
    }

    /// The values of parameter `i` so many standard deviations of its prior below and above its centre,
    /// physical.
    fn reach(&self, i: usize, sds: f64) -> [f64; 2] {
        let (mut z, scales) = (self.parameters().centre(), self.parameters().scales());
        let middle = z[i];
        [-sds, sds].map(|sds| {
            z[i] = middle + sds * scales[i];
            self.parameters().physical(&z)[i]
        })
    }

    /// The other parameters and the noise fitted roughly to the data, in turns; none where the model fails.
    fn fitted_at(&self, held: &[usize], at: Vec<f64>, calls: &mut Calls) -> Option<Fitted> {
        let p = self.parameters().len();
        let mut start = self.parameters().physical(&self.parameters().centre());
        held.iter().zip(&at).for_each(|(&i, value)| start[i] = *value);
        let first = self.screen(Some(&start));
        calls.value += 1;
        let first = first.ok()?;
        let (mut z, mut cost) = (first.z, first.cost);
        let free: Vec<usize> = (0..p).filter(|i| !held.contains(i)).collect();
        let quick = TrustRegion {
            method: Method::GaussNewton,
            max_evaluations: EVALUATIONS,
            tolerance: ROUGH,
            ..TrustRegion::default()
        };
        for _ in 0..if free.is_empty() { 0 } else { TURNS } {
            let inner = Conditional::new(self, z.clone(), free.clone());
            let from: Vec<f64> = free.iter().map(|&i| z[i]).collect();
            let minimum = minimise(&inner, &from, &quick).ok()?;
            *calls = calls.plus(minimum.calls);
            z = inner.filled(&minimum.z);
            // The turn ended with this very call of the model.
            let prediction = self.predict(&self.parameters().physical(&z[..p]), Order::First).ok()?;
            let noise = z[p..].to_vec();
            self.settle_noise(&mut z, &prediction.values);
            self.refine_noise(&mut z, &prediction, &noise, REFINED).ok()?;
            let parts = self.parts_of(&z, prediction, Order::Value, None).ok()?;
            let before = cost;
            cost = -(parts.ln_likelihood + parts.ln_prior);
            if before - cost < ROUGH || self.floating().is_empty() {
                break;
            }
        }
        cost.is_finite().then(|| Fitted { at, cost, parameters: self.parameters().physical(&z[..p]) })
    }
}
