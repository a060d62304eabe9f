//! Bridge sampling: the evidence from draws of a posterior.

use super::sampler::Target;
use crate::density::{Calls, Gaussian};
use crate::error::InferenceError;
use rand::RngExt;
use rand_distr::StandardNormal;
use rijke_numerics::{Cholesky, Matrix, Stream};
use std::f64::consts::PI;

/// An evidence by bridge sampling.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bridge {
    pub(crate) ln_marginal: f64,
    /// Relative error of the evidence, that is, the error of its logarithm, nats.
    pub(crate) standard_error: f64,
    /// Mean of ln likelihood minus the evidence over the posterior, nats.
    pub(crate) information: f64,
}

/// The evidence of `target` from `draws` of its posterior, in the standard normal coordinates of the prior.
///
/// The first half of the draws fits a Gaussian g; the second half and as many draws of g are bridged by the
/// optimal function of Meng & Wong (1996, Statistica Sinica 6, 831), iterated to its fixed point. The error
/// is that of Fruehwirth-Schnatter (2004, Econometrics Journal 7, 143), with the correlation of the draws.
pub(crate) fn bridge(
    target: &dyn Target,
    draws: &[Vec<f64>],
    stream: &mut Stream,
    calls: &mut Calls,
) -> Result<Bridge, InferenceError> {
    let (fitting, rest) = draws.split_at(draws.len() / 2);
    let g = gaussian(fitting)?;
    let n = g.mean.len();
    // ln of unnormalised posterior over g.
    let mut ln_ratio = |xi: &[f64], ln_g: f64| -> Result<(f64, f64), InferenceError> {
        calls.value += 1;
        let ln_likelihood = match target.ln_likelihood(xi) {
            Ok(value) => value,
            Err(error) if error.is_recoverable() => f64::NEG_INFINITY,
            Err(error) => return Err(error),
        };
        let square: f64 = xi.iter().map(|x| x * x).sum();
        Ok((ln_likelihood - 0.5 * (square + n as f64 * (2.0 * PI).ln()) - ln_g, ln_likelihood))
    };
    let peak = g.ln_density(&vec![0.0; n]);
    let posterior: Vec<(f64, f64)> =
        rest.iter().map(|xi| ln_ratio(xi, peak - 0.5 * g.distance(xi).powi(2))).collect::<Result<_, _>>()?;
    let proposed: Vec<f64> = rest
        .iter()
        .map(|_| {
            let eta: Vec<f64> = (0..n).map(|_| stream.sample(StandardNormal)).collect();
            Ok(ln_ratio(&g.point(&eta), g.ln_density(&eta))?.0)
        })
        .collect::<Result<_, InferenceError>>()?;
    let posterior_ratios: Vec<f64> = posterior.iter().map(|p| p.0).collect();
    let (ln_marginal, standard_error) = optimal(&posterior_ratios, &proposed);
    let mean = posterior.iter().map(|p| p.1).sum::<f64>() / posterior.len() as f64;
    Ok(Bridge { ln_marginal, standard_error, information: mean - ln_marginal })
}

/// The fixed point of Meng and Wong from ln(q/g) at posterior draws and at draws of g, and its error.
fn optimal(posterior: &[f64], proposed: &[f64]) -> (f64, f64) {
    let shift = posterior.iter().sum::<f64>() / posterior.len() as f64;
    let ratios = |l: &[f64]| l.iter().map(|l| (l - shift).exp()).collect::<Vec<f64>>();
    let (at_posterior, at_g) = (ratios(posterior), ratios(proposed));
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let mut r = 1.0;
    for _ in 0..1000 {
        // Equal weights for both kinds of draw.
        let above: Vec<f64> = at_g.iter().map(|l| l / (0.5 * (l + r))).collect();
        let below: Vec<f64> = at_posterior.iter().map(|l| 1.0 / (0.5 * (l + r))).collect();
        let next = mean(&above) / mean(&below);
        let change = (next / r - 1.0).abs();
        r = next;
        if change < 1e-12 {
            break;
        }
    }
    let f2: Vec<f64> = at_g.iter().map(|l| l / (l + r)).collect();
    let f1: Vec<f64> = at_posterior.iter().map(|l| r / (l + r)).collect();
    let relative = |f: &[f64], time: f64| {
        let m = mean(f);
        time * f.iter().map(|v| (v - m).powi(2)).sum::<f64>() / (f.len() as f64 * m).powi(2)
    };
    let error = (relative(&f2, 1.0) + relative(&f1, correlation_time(&f1))).sqrt();
    (shift + r.ln(), error)
}

/// By how much correlation widens the error of the mean: 1 + 2 sum of autocorrelations, over Geyer's (1992)
/// initial positive pairs.
fn correlation_time(f: &[f64]) -> f64 {
    let n = f.len();
    let m = f.iter().sum::<f64>() / n as f64;
    let covariance = |lag: usize| (lag..n).map(|i| (f[i] - m) * (f[i - lag] - m)).sum::<f64>();
    let variance = covariance(0);
    if variance <= 0.0 {
        return 1.0;
    }
    let mut time = -1.0;
    for lag in (0..n / 2).step_by(2) {
        let pair = (covariance(lag) + covariance(lag + 1)) / variance;
        if pair <= 0.0 {
            break;
        }
        time += 2.0 * pair;
    }
    time.max(1.0 / n as f64)
}

fn gaussian(draws: &[Vec<f64>]) -> Result<Gaussian, InferenceError> {
    let (n, count) = (draws.first().map_or(0, Vec::len), draws.len() as f64);
    let mean: Vec<f64> = (0..n).map(|i| draws.iter().map(|d| d[i]).sum::<f64>() / count).collect();
    let covariance = Matrix::from_fn(n, n, |i, j| {
        draws.iter().map(|d| (d[i] - mean[i]) * (d[j] - mean[j])).sum::<f64>() / (count - 1.0)
    });
    Gaussian::from_hessian(&mean, 0.0, &Cholesky::new(&covariance)?.inverse())
}
