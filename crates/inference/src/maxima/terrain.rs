//! What a search from several starts stands on: a posterior, and where to start.

use crate::density::{Calls, Gaussian, TrustRegion};
use crate::error::InferenceError;
use crate::evidence::Laplace;
use crate::fit::{Approach, Fit, Posterior};
use crate::numbers::normal_quantile;
use crate::problem::Images;
use rand::RngExt;
use rijke_numerics::Streams;

/// A posterior as the ground of a search. A start is a list of physical parameters; None for the centre of
/// the prior.
pub(crate) struct Terrain<'a> {
    pub(crate) posterior: &'a Posterior<'a>,
    /// The minimiser of every start.
    pub(crate) search: TrustRegion,
    /// Random streams of starts.
    pub(crate) streams: Streams,
}

impl Terrain<'_> {
    /// Where a search from `start` begins, and J there.
    pub(super) fn screen(&self, start: Option<&[f64]>) -> Result<Approach, InferenceError> {
        self.posterior.screen(start)
    }

    /// Brings a point within a tenth of a standard deviation of a maximum, or ends at one of the `known`
    /// ones.
    pub(super) fn approach(&self, from: Approach, known: &[Gaussian]) -> Result<Approach, InferenceError> {
        self.posterior.approach(from, &self.search, known)
    }

    /// Goes the rest of the way, and asks what Laplace's method says there.
    pub(super) fn finish(&self, near: Approach) -> Result<Peak, InferenceError> {
        let fit = self.posterior.finish(near, &self.search)?;
        let laplace = self.posterior.laplace(&fit).map_err(|e| e.to_string());
        let touching = |l: &Laplace| Gaussian::from_hessian(&l.mean, fit.cost, &l.hessian).ok();
        let gaussian = match &laplace {
            Ok(laplace) => touching(laplace),
            // Improper priors have maxima, too.
            Err(_) => self.posterior.laplace_of_likelihood(&fit).ok().as_ref().and_then(touching),
        };
        Ok(Peak {
            z: self.inner(&fit.working),
            cost: fit.cost,
            converged: fit.stop.converged(),
            calls: fit.calls,
            ln_marginal: laplace.as_ref().ok().map(|l| l.evidence.ln_marginal),
            gaussian,
            fit,
            laplace,
        })
    }

    /// The coordinates of a point that an evidence integrates over.
    pub(super) fn inner(&self, z: &[f64]) -> Vec<f64> {
        self.posterior.integrated().iter().map(|&i| z[i]).collect()
    }

    /// Points at which the model is known to predict nearly the same as at this end of a search.
    pub(super) fn images(&self, fit: &Fit) -> Images {
        self.posterior.parameters().images(&fit.parameters, |a| self.posterior.forward().aliases(a))
    }

    /// ln density of the prior at a point less that at this end of a search.
    pub(super) fn above(&self, z: &[f64], fit: &Fit) -> f64 {
        let parameters = self.posterior.parameters();
        let p = parameters.len();
        let at = |z: &[f64]| parameters.ln_density(&z[..p]).map_or(f64::NEG_INFINITY, |d| d.value);
        at(z) - at(&fit.working)
    }

    /// A start with less noise, to which a search that ended here could not go for its noise.
    pub(super) fn with_less_noise(&self, fit: &Fit) -> Option<Vec<f64>> {
        self.posterior.with_less_noise(&fit.working)
    }

    /// Starts spread over the prior with its standard deviations taken `width` times, from `count` points of
    /// a unit cube, other ones for each `round`; none if the prior is improper.
    pub(super) fn spread(&self, count: usize, width: f64, round: usize) -> Vec<Vec<f64>> {
        let parameters = self.posterior.parameters();
        if parameters.improper().is_some() || parameters.is_empty() {
            return Vec::new();
        }
        let cube = latin(count, parameters.len(), self.streams, round);
        let physical = |u: Vec<f64>| {
            let xi: Vec<f64> = u.into_iter().map(|u| width * normal_quantile(u)).collect();
            parameters.physical(&parameters.from_standard_normal(&xi))
        };
        cube.into_iter().map(physical).collect()
    }
}

/// A Latin hypercube: `count` points in the unit cube, one in each of `count` slices of every coordinate
/// (McKay, Beckman & Conover 1979, Technometrics 21, 239). However many coordinates there are, one alone is
/// spread evenly. Every `round` has other points.
pub(super) fn latin(count: usize, size: usize, streams: Streams, round: usize) -> Vec<Vec<f64>> {
    let mut points = vec![vec![0.0; size]; count];
    for i in 0..size {
        let again = if round == 0 { String::new() } else { format!("/{round}") };
        let mut stream = streams.stream(&format!("inference/spread/{i}{again}"));
        let mut slices: Vec<usize> = (0..count).collect();
        for k in (1..count).rev() {
            slices.swap(k, stream.random_range(0..=k));
        }
        for (point, slice) in points.iter_mut().zip(slices) {
            point[i] = (slice as f64 + stream.random_range(0.0..1.0)) / count as f64;
        }
    }
    points
}

/// The end of a search with what Laplace's method says there.
pub(crate) struct Peak {
    pub(crate) fit: Fit,
    /// Laplace's method there, or why it does not apply.
    pub(crate) laplace: Result<Laplace, String>,
    /// The integrated coordinates.
    pub(crate) z: Vec<f64>,
    pub(crate) cost: f64,
    pub(crate) converged: bool,
    pub(crate) calls: Calls,
    /// ln of its part of the evidence, if that exists.
    pub(crate) ln_marginal: Option<f64>,
    /// The Gaussian that touches it.
    pub(crate) gaussian: Option<Gaussian>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_every_slice_of_every_coordinate_holds_one_point() {
        for (count, size) in [(32, 1), (17, 5), (8, 40)] {
            let points = latin(count, size, Streams::new(3), 0);
            for i in 0..size {
                let mut slices: Vec<usize> = points.iter().map(|p| (p[i] * count as f64) as usize).collect();
                slices.sort_unstable();
                assert_eq!(slices, (0..count).collect::<Vec<_>>());
            }
        }
    }
}
