//! Importance sampling from Laplace's Gaussian: does it cover the posterior, and what is the evidence if not?

use crate::density::{Gaussian, Objective};
use crate::error::InferenceError;
use crate::numbers::shares;
use rand::RngExt;
use rand_distr::StandardNormal;
use rayon::prelude::*;
use rijke_numerics::{InOrder, Order, Streams};
use serde::{Deserialize, Serialize};

/// An evidence by importance sampling, with the diagnosis of its weights.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Importance {
    /// ln of the mean weight, with the largest weights smoothed: ln P(D) without Laplace's approximation, in
    /// nats.
    pub ln_marginal: f64,
    /// Its standard error, nats; meaningful if `k_hat` is good.
    pub standard_error: f64,
    /// Shape of the generalised Pareto tail of the weights: above [`Importance::k_limit`] neither Laplace's
    /// value nor the corrected one is to be trusted.
    pub k_hat: f64,
    /// Number of draws.
    pub draws: usize,
    /// Draws at which the objective had no value, which count as probability zero: beyond a bound, or a
    /// failed model.
    pub refused: usize,
}

/// Relative standard deviation of the weights below which the shape of their tail is not read.
const NEGLIGIBLE_SPREAD: f64 = 0.01;

impl Importance {
    /// The largest good `k_hat` for this number of draws: min(1 - 1/log10 S, 0.7) (Vehtari et al. 2024,
    /// section 3.2).
    #[must_use]
    pub fn k_limit(&self) -> f64 {
        (1.0 - 1.0 / (self.draws as f64).log10()).min(0.7)
    }

    /// True if the weights have a tail light enough for `ln_marginal` and `standard_error` to mean something,
    /// or hardly differ: a tail among weights that are all within 1 % of each other has a shape, but no
    /// effect.
    #[must_use]
    pub fn good(&self) -> bool {
        self.k_hat <= self.k_limit() || self.standard_error * (self.draws as f64).sqrt() < NEGLIGIBLE_SPREAD
    }
}

/// Draws after which the weights are looked at for the first time.
const FIRST_LOOK: usize = 128;
/// Standard error, nats, below which good weights are enough.
const ENOUGH: f64 = 0.02;

/// Weighs points of `proposal` by exp(-J) over the proposal density: 128 of them, and twice as many until the
/// weights are good and the standard error is below 0.02 nats, or there are `draws`.
///
/// Cost: as many values of the objective, in parallel; each draw has its own stream, so threads do not
/// matter.
///
/// # Errors
/// Errors that are not recoverable; recoverable ones are counted as weight zero.
pub fn importance(
    objective: &dyn Objective,
    proposal: &Gaussian,
    draws: usize,
    streams: Streams,
) -> Result<Importance, InferenceError> {
    weighed(objective, &[(1.0, proposal.clone())], draws, streams)
}

/// As [`importance`], with points of a mixture of Gaussians, each with its weight: one for every maximum.
pub(crate) fn weighed(
    objective: &dyn Objective,
    proposal: &[(f64, Gaussian)],
    draws: usize,
    streams: Streams,
) -> Result<Importance, InferenceError> {
    let mut ln_weights = Vec::with_capacity(draws);
    let mut wanted = draws.min(FIRST_LOOK);
    loop {
        let more: Vec<f64> = (ln_weights.len()..wanted)
            .into_par_iter()
            .map(|k| ln_weight(objective, proposal, k, streams))
            .in_order::<Result<_, _>>()?;
        ln_weights.extend(more);
        let found = verdict(&ln_weights);
        if wanted == draws || (found.good() && found.standard_error < ENOUGH) {
            return Ok(found);
        }
        wanted = draws.min(2 * wanted);
    }
}

/// ln of the weight of draw number `k`.
fn ln_weight(
    objective: &dyn Objective,
    proposal: &[(f64, Gaussian)],
    k: usize,
    streams: Streams,
) -> Result<f64, InferenceError> {
    let Some((_, first)) = proposal.first() else { return Ok(f64::NEG_INFINITY) };
    let mut stream = streams.stream(&format!("inference/importance/{k}"));
    let xi: Vec<f64> = (0..first.mean.len()).map(|_| stream.sample(StandardNormal)).collect();
    let total: f64 = proposal.iter().map(|(weight, _)| weight).sum();
    let (point, ln_density) = if let [(_, only)] = proposal {
        (only.point(&xi), only.ln_density(&xi))
    } else {
        let (mut left, mut chosen) = (stream.random_range(0.0..1.0) * total, first);
        for (weight, gaussian) in proposal {
            chosen = gaussian;
            left -= weight;
            if left < 0.0 {
                break;
            }
        }
        let point = chosen.point(&xi);
        let density = |(weight, g): &(f64, Gaussian)| (weight / total).ln() + g.ln_density_at(&point);
        let ln: Vec<f64> = proposal.iter().map(density).collect();
        (point, shares(&ln).1)
    };
    match objective.evaluate(&point, Order::Value) {
        Ok(energy) => Ok(-energy.value - ln_density),
        Err(error) if error.is_recoverable() => Ok(f64::NEG_INFINITY),
        Err(error) => Err(error),
    }
}

fn verdict(ln_weights: &[f64]) -> Importance {
    let draws = ln_weights.len();
    let refused = ln_weights.iter().filter(|w| **w == f64::NEG_INFINITY).count();
    let (weights, largest, k_hat) = smooth(ln_weights.to_vec());
    let mean = weights.iter().sum::<f64>() / draws as f64;
    let variance = weights.iter().map(|w| (w - mean).powi(2)).sum::<f64>() / (draws as f64 - 1.0);
    Importance {
        ln_marginal: largest + mean.ln(),
        standard_error: (variance / draws as f64).sqrt() / mean,
        k_hat,
        draws,
        refused,
    }
}

/// Pareto-smoothed weights relative to the largest, its logarithm, and the shape of their tail (Vehtari et
/// al. 2024).
fn smooth(ln_weights: Vec<f64>) -> (Vec<f64>, f64, f64) {
    let n = ln_weights.len();
    let largest = ln_weights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if largest == f64::NEG_INFINITY {
        return (vec![0.0; n], largest, f64::INFINITY);
    }
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| ln_weights[i].total_cmp(&ln_weights[j]));
    let mut weights: Vec<f64> = ln_weights.iter().map(|w| (w - largest).exp()).collect();
    let tail = (0.2 * n as f64).min(3.0 * (n as f64).sqrt()).ceil() as usize;
    if tail < 5 || tail >= n {
        return (weights, largest, f64::INFINITY);
    }
    let cut = weights[order[n - tail - 1]];
    let excess: Vec<f64> = order[n - tail..].iter().map(|&i| weights[i] - cut).collect();
    if excess[tail - 1] - excess[0] <= 1e-10 {
        // Weights equal to rounding: the proposal is the posterior.
        return (weights, largest, f64::NEG_INFINITY);
    }
    let (shape, scale) = pareto(&excess);
    for (rank, &i) in order[n - tail..].iter().enumerate() {
        let p = (rank as f64 + 0.5) / tail as f64;
        weights[i] = (cut + scale * (-shape * (-p).ln_1p()).exp_m1() / shape).min(1.0);
    }
    (weights, largest, shape)
}

/// Shape and scale of a generalised Pareto distribution from excesses in ascending order: the quasi-Bayesian
/// estimate of Zhang & Stephens (2009), with the shape drawn towards 1/2 by ten pseudo-observations as in
/// Vehtari et al.
fn pareto(excess: &[f64]) -> (f64, f64) {
    let n = excess.len();
    let count = n as f64;
    let quartile = excess[((count / 4.0 + 0.5).floor() as usize).max(1) - 1].max(f64::MIN_POSITIVE);
    let shape_at = |theta: f64| excess.iter().map(|x| (-theta * x).ln_1p()).sum::<f64>() / count;
    let points = 30 + count.sqrt().floor() as usize;
    let thetas: Vec<f64> = (1..=points)
        .map(|j| {
            let spread = 1.0 - (points as f64 / (j as f64 - 0.5)).sqrt();
            1.0 / excess[n - 1] + spread / (3.0 * quartile)
        })
        .collect();
    let profile: Vec<f64> = thetas
        .iter()
        .map(|&t| {
            let k = shape_at(t);
            count * ((-t / k).ln() - k - 1.0)
        })
        .collect();
    let best = profile.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let total: f64 = profile.iter().map(|l| (l - best).exp()).sum();
    let theta: f64 = thetas.iter().zip(&profile).map(|(t, l)| t * (l - best).exp() / total).sum();
    let shape = shape_at(theta);
    let scale = -shape / theta;
    ((shape * count + 5.0) / (count + 10.0), scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oracle_shape_of_known_pareto_tails() {
        // Excesses placed at the quantiles of a generalised Pareto distribution of known shape and scale 2.
        // The estimate is pulled to 1/2 by ten pseudo-observations, undone here.
        for shape in [-0.2, 0.1, 0.5, 0.9] {
            let n = 4000;
            let excess: Vec<f64> = (0..n)
                .map(|i| {
                    let p = (f64::from(i) + 0.5) / f64::from(n);
                    2.0 * (-shape * (-p).ln_1p()).exp_m1() / shape
                })
                .collect();
            let (k, scale) = pareto(&excess);
            let raw = (k * f64::from(n + 10) - 5.0) / f64::from(n);
            assert!((raw - shape).abs() < 0.02 && (scale - 2.0).abs() < 0.05, "{shape}: {raw}, {scale}");
        }
    }

    /// ArviZ 0.23.4, `arviz.psislw` of the same logarithms: shape, largest weight and sum of squares of the
    /// smoothed weights, whose sum is one.
    #[test]
    fn oracle_smoothed_weights_are_those_of_arviz() {
        for (tail, shape, largest, squares) in [
            (0.3, 0.33685397318586036, 0.007047369135692388, 0.0012065227050370624),
            (0.6, 0.5990237442528413, 0.03924857340820808, 0.004023922366578527),
            (0.9, 0.8602743264669039, 0.1423490821351557, 0.02824741949621158),
        ] {
            let of = |i: u32| -tail * (1.0 - (f64::from(i) * 0.6180339887498949).fract()).ln();
            let (weights, _, k) = smooth((1..=1000).map(of).collect());
            let sum: f64 = weights.iter().sum();
            let found = [
                k,
                weights.iter().copied().fold(0.0, f64::max) / sum,
                weights.iter().map(|w| w * w).sum::<f64>() / (sum * sum),
            ];
            for (a, b) in found.into_iter().zip([shape, largest, squares]) {
                assert!((a - b).abs() < 1e-6 * b, "tail {tail}: {a} {b}");
            }
        }
    }

    #[test]
    fn exact_equal_weights_stay_equal() {
        let (weights, largest, k) = smooth(vec![-7.0; 300]);
        assert_eq!((weights.iter().sum::<f64>(), largest), (300.0, -7.0));
        assert_eq!(k, f64::NEG_INFINITY);
        assert_eq!(smooth(vec![f64::NEG_INFINITY; 300]).2, f64::INFINITY);
    }
}
