//! What a search from several starts stands on: a posterior, or any objective; and where to start.

use super::explore::{Ground, Peak};
use crate::density::{Calls, Gaussian, Minimum, Objective, TrustRegion, minimise};
use crate::error::InferenceError;
use crate::evidence::Laplace;
use crate::fit::{Approach, Fit, Posterior};
use crate::numbers::normal_quantile;
use rand::RngExt;
use rijke_numerics::{Order, Streams};

/// A posterior as the ground of a search.
pub(crate) struct Terrain<'a> {
    pub(crate) posterior: &'a Posterior<'a>,
    /// The minimiser of every start.
    pub(crate) search: TrustRegion,
    /// Random streams of starts.
    pub(crate) streams: Streams,
}

/// A fit with Laplace's method at it, or why that does not apply.
pub(crate) type Fitted = (Fit, Result<Laplace, String>);

impl Ground for Terrain<'_> {
    type Fit = Fitted;

    fn screen(&self, start: Option<&[f64]>) -> Result<Approach, InferenceError> {
        self.posterior.screen(start)
    }

    fn approach(&self, from: Approach, known: &[Gaussian]) -> Result<Approach, InferenceError> {
        self.posterior.approach(from, &self.search, known)
    }

    fn finish(&self, near: Approach) -> Result<Fitted, InferenceError> {
        let fit = self.posterior.finish(near, &self.search)?;
        let laplace = self.posterior.laplace(&fit).map_err(|e| e.to_string());
        Ok((fit, laplace))
    }

    fn peak(&self, (fit, laplace): Fitted) -> Peak<Fitted> {
        let z = self.inner(&fit.working);
        let touching = |l: &Laplace| Gaussian::from_hessian(&l.mean, fit.cost, &l.hessian).ok();
        let gaussian = match &laplace {
            Ok(laplace) => touching(laplace),
            // Improper priors have maxima, too.
            Err(_) => self.posterior.laplace_of_likelihood(&fit).ok().as_ref().and_then(touching),
        };
        Peak {
            z,
            cost: fit.cost,
            converged: fit.stop.converged(),
            calls: fit.calls,
            ln_marginal: laplace.as_ref().ok().map(|l| l.evidence.ln_marginal),
            gaussian,
            fit: (fit, laplace),
        }
    }

    fn inner(&self, z: &[f64]) -> Vec<f64> {
        self.posterior.integrated().iter().map(|&i| z[i]).collect()
    }

    fn images(&self, (fit, _): &Fitted) -> Vec<Vec<f64>> {
        let mut all =
            self.posterior.parameters().images(&fit.parameters, |a| self.posterior.forward().aliases(a));
        all.extend(self.posterior.with_less_noise(&fit.working));
        all
    }

    fn spread(&self, count: usize, width: f64) -> Vec<Vec<f64>> {
        let parameters = self.posterior.parameters();
        if parameters.improper().is_some() || parameters.is_empty() {
            return Vec::new();
        }
        let cube = latin(count, parameters.len(), self.streams);
        let physical = |u: Vec<f64>| {
            let xi: Vec<f64> = u.into_iter().map(|u| width * normal_quantile(u)).collect();
            parameters.physical(&parameters.from_standard_normal(&xi))
        };
        cube.into_iter().map(physical).collect()
    }
}

/// A Latin hypercube: `count` points in the unit cube, one in each of `count` slices of every coordinate
/// (McKay, Beckman & Conover 1979, Technometrics 21, 239). However many coordinates there are, one alone is
/// spread evenly.
pub(super) fn latin(count: usize, size: usize, streams: Streams) -> Vec<Vec<f64>> {
    let mut points = vec![vec![0.0; size]; count];
    for i in 0..size {
        let mut stream = streams.stream(&format!("inference/spread/{i}"));
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

/// Any objective as the ground of a search; its starts are points of its own coordinates.
pub(crate) struct Plain<'a> {
    pub(crate) objective: &'a dyn Objective,
    pub(crate) start: &'a [f64],
    /// The minimiser of every start.
    pub(crate) search: TrustRegion,
    /// Random streams of starts.
    pub(crate) streams: Streams,
}

impl Ground for Plain<'_> {
    type Fit = Minimum;

    fn screen(&self, start: Option<&[f64]>) -> Result<Approach, InferenceError> {
        let z = start.unwrap_or(self.start).to_vec();
        let cost = self.objective.evaluate(&z, Order::Value).map_err(|source| InferenceError::NoStart {
            at: self.objective.named_point(&z),
            source: Box::new(source),
        })?;
        let calls = Calls { value: 1, ..Calls::default() };
        Ok(Approach {
            z,
            small: Vec::new(),
            calls,
            cost: cost.value,
            ln_likelihood: f64::INFINITY,
            settled: false,
        })
    }

    fn approach(&self, from: Approach, _: &[Gaussian]) -> Result<Approach, InferenceError> {
        let end = minimise(self.objective, &from.z, &self.search)?;
        Ok(Approach {
            calls: from.calls.plus(end.calls),
            cost: end.energy.value,
            settled: end.stop.converged(),
            z: end.z,
            ..from
        })
    }

    fn finish(&self, near: Approach) -> Result<Minimum, InferenceError> {
        let mut end = minimise(self.objective, &near.z, &self.search)?;
        end.calls = end.calls.plus(near.calls);
        Ok(end)
    }

    fn peak(&self, minimum: Minimum) -> Peak<Minimum> {
        let gaussian = Gaussian::at(self.objective, &minimum.z).ok();
        Peak {
            z: minimum.z.clone(),
            cost: minimum.energy.value,
            converged: minimum.stop.converged(),
            calls: minimum.calls,
            ln_marginal: gaussian.as_ref().map(|g| g.ln_integral),
            gaussian,
            fit: minimum,
        }
    }

    fn inner(&self, z: &[f64]) -> Vec<f64> {
        z.to_vec()
    }

    fn images(&self, fit: &Minimum) -> Vec<Vec<f64>> {
        self.objective.aliases(&fit.z)
    }

    fn spread(&self, count: usize, width: f64) -> Vec<Vec<f64>> {
        let scales = self.objective.scales();
        let point = |u: Vec<f64>| match self.objective.region(&u) {
            // Nothing lies outside of a region.
            Some(inside) => (width <= 1.0).then_some(inside),
            None => Some(
                (0..u.len()).map(|i| self.start[i] + width * scales[i] * normal_quantile(u[i])).collect(),
            ),
        };
        latin(count, self.objective.size(), self.streams).into_iter().filter_map(point).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_every_slice_of_every_coordinate_holds_one_point() {
        for (count, size) in [(32, 1), (17, 5), (8, 40)] {
            let points = latin(count, size, Streams::new(3));
            for i in 0..size {
                let mut slices: Vec<usize> = points.iter().map(|p| (p[i] * count as f64) as usize).collect();
                slices.sort_unstable();
                assert_eq!(slices, (0..count).collect::<Vec<_>>());
            }
        }
    }
}
