//! The whole health check for any negative log density.

use super::assess::AssessOptions;
use super::health::Health;
use crate::density::{Gaussian, Minimum, Objective};
use crate::error::InferenceError;
use crate::maxima::{Apart, OtherMaximum, Peak, Plain, explore, further_maxima, shares};
use crate::sample::weighed;

/// All maxima of a density, its integral summed over them, and what the checks found.
#[derive(Clone, Debug)]
pub struct Surveyed {
    /// The best maximum: the one with the largest integral, by Laplace's method.
    pub minimum: Minimum,
    /// The Gaussian that touches it, if the Hessian there is positive definite.
    pub gaussian: Option<Gaussian>,
    /// ln of the integral of exp(-J), summed over all maxima, nats; nothing without that Gaussian.
    pub ln_integral: Option<f64>,
    /// The checks: other maxima with their shares, importance sampling from all of them, failed starts,
    /// warnings.
    pub health: Health,
}

/// Finds the maxima of exp(-J) from `start`, from `options.starts`, from [`Objective::aliases`] and from the
/// best points of [`Objective::region`], sums Laplace's integrals over them, and checks the sum by importance
/// sampling.
///
/// # Errors
/// As [`crate::Posterior::assess`].
pub fn survey(
    objective: &dyn Objective,
    start: &[f64],
    options: &AssessOptions,
) -> Result<Surveyed, InferenceError> {
    let ground = Plain { objective, start, search: options.search, streams: options.streams };
    let found = explore(&ground, &options.starts, options.breadth())?;
    let mut health = Health::of_search(&found);
    let peaks: Vec<Peak<Minimum>> =
        found.peaks.into_iter().enumerate().filter(|(k, p)| *k == 0 || p.converged).map(|(_, p)| p).collect();
    let (shares, total) = shares(&peaks.iter().map(|p| p.ln_marginal).collect::<Vec<_>>());
    let best = &peaks[0];
    health.share = shares[0];
    let height = |p: &Peak<Minimum>| p.ln_marginal.unwrap_or(-p.cost);
    health.other_modes = (1..peaks.len())
        .map(|k| OtherMaximum {
            parameters: peaks[k].z.clone(),
            ln_marginal: peaks[k].ln_marginal,
            below: height(best) - height(&peaks[k]),
            share: shares[k],
            apart: apart(best, &peaks[k].z),
        })
        .collect();
    health.warnings.extend(further_maxima(&health.other_modes));
    if !best.converged {
        health.warnings.push(format!("the search did not converge: {}", best.fit.stop));
    }
    let proposal: Vec<(f64, Gaussian)> =
        peaks.iter().zip(&shares).filter_map(|(p, s)| Some((*s, p.gaussian.clone()?))).collect();
    let ln_integral = best.ln_marginal.map(|_| total);
    if ln_integral.is_none() {
        health.warnings.push("the Hessian is not positive definite at the best point".to_owned());
    } else if options.draws == 0 {
        health.warnings.push("the evidence was not checked by importance sampling".to_owned());
    } else if objective.size() > 0 {
        health.weigh(weighed(objective, &proposal, options.draws, options.streams)?, total);
    }
    Ok(Surveyed { minimum: best.fit.clone(), gaussian: best.gaussian.clone(), ln_integral, health })
}

/// The coordinates that tell a maximum from the best one, by the number of standard deviations between them.
fn apart(best: &Peak<Minimum>, other: &[f64]) -> Vec<Apart> {
    let sds = best.gaussian.as_ref().map_or_else(|| vec![1.0; other.len()], Gaussian::sd);
    let mut all: Vec<Apart> = (0..other.len())
        .map(|i| Apart {
            parameter: format!("z{i}"),
            unit: "1".to_owned(),
            value: other[i],
            best: best.z[i],
            sds: (other[i] - best.z[i]).abs() / sds[i],
        })
        .collect();
    all.sort_by(|a, b| b.sds.total_cmp(&a.sds));
    all
}
