//! Noise by maximum marginal likelihood: chosen to make the evidence largest, not the posterior.

use crate::density::{Calls, Energy, Gaussian, Method, Objective, Stop, TrustRegion, minimise};
use crate::error::InferenceError;
use crate::fit::{Fit, Held, Posterior};
use rijke_numerics::{Cholesky, Matrix, Order};
use std::sync::Mutex;

/// The noise that maximises the evidence, and the parameters that are most probable with it.
#[derive(Clone, Debug)]
pub struct MarginalFit {
    /// The fit with that noise; [`Posterior::laplace`] at it gives the maximised evidence.
    pub fit: Fit,
    /// ln of the evidence there, nats.
    pub ln_marginal: f64,
    /// Why the search over the noise ended.
    pub stop: Stop,
}

/// -ln P(D | noise) by Laplace's method, as a function of ln sd of the floated groups.
struct NoiseEvidence<'a> {
    posterior: &'a Posterior<'a>,
    start: Vec<f64>,
    /// The coordinates searched over: ln sd of floated groups.
    outer: Vec<usize>,
    /// The coordinates integrated over.
    inner: Vec<usize>,
    search: TrustRegion,
    calls: Mutex<Calls>,
}

/// Step of the five-point difference of the Hessian; its error is h^4 times the fifth derivative, 1e-12 for
/// exponentials.
const STEP: f64 = 1e-3;

impl Posterior<'_> {
    /// Maximises the Laplace evidence over floated noise, from `fit`.
    ///
    /// The gradient is analytic but for d(ln det A)/du, which needs third derivatives of the model: A is
    /// differenced along the path of the maximum (five points, relative error about 1e-11). Cost: per step
    /// and group four calls with second derivatives, and a short fit.
    ///
    /// # Errors
    /// As [`Posterior::laplace`]; a posterior without floated noise is returned as it is.
    pub fn maximise_marginal(&self, fit: &Fit) -> Result<MarginalFit, InferenceError> {
        let inner = self.integrated();
        let outer: Vec<usize> = (0..self.size()).filter(|i| !inner.contains(i)).collect();
        let problem = NoiseEvidence {
            posterior: self,
            start: fit.working.clone(),
            search: TrustRegion { method: Method::Newton, ..TrustRegion::default() },
            calls: Mutex::new(Calls::default()),
            outer,
            inner,
        };
        let from: Vec<f64> = problem.outer.iter().map(|&i| fit.working[i]).collect();
        let search = TrustRegion { method: Method::Bfgs, tolerance: 1e-16, ..TrustRegion::default() };
        let minimum = minimise(&problem, &from, &search)?;
        let whole = problem.inner_fit(&minimum.z)?;
        // An empty search from the point puts the noise and the parameters into the form of a fit.
        let mut end = self.map_from(&whole, &TrustRegion { max_evaluations: 1, ..search })?;
        end.calls = end.calls.plus(problem.calls.lock().map_or(Calls::default(), |c| *c));
        end.stop = minimum.stop.clone();
        Ok(MarginalFit { fit: end, ln_marginal: -minimum.energy.value, stop: minimum.stop })
    }
}

impl NoiseEvidence<'_> {
    fn with_noise(&self, noise: &[f64]) -> Held<'_> {
        let mut whole = self.start.clone();
        for (&i, &u) in self.outer.iter().zip(noise) {
            whole[i] = u;
        }
        Held::new(self.posterior, whole, self.inner.clone())
    }

    /// All coordinates at the maximum over the parameters with the noise held.
    fn inner_fit(&self, noise: &[f64]) -> Result<Vec<f64>, InferenceError> {
        let held = self.with_noise(noise);
        let start: Vec<f64> = self.inner.iter().map(|&i| self.start[i]).collect();
        let minimum = minimise(&held, &start, &self.search)?;
        if let Ok(mut calls) = self.calls.lock() {
            *calls = calls.plus(minimum.calls);
        }
        Ok(held.filled(&minimum.z))
    }

    fn hessian_along(&self, at: &[f64], direction: &[f64], h: f64) -> Result<Matrix, InferenceError> {
        let moved: Vec<f64> = at.iter().zip(direction).map(|(z, d)| z + h * d).collect();
        if let Ok(mut calls) = self.calls.lock() {
            calls.count(Order::Second);
        }
        Ok(self.posterior.evaluate(&moved, Order::Second)?.hessian.select(&self.inner))
    }
}

impl Objective for NoiseEvidence<'_> {
    fn size(&self) -> usize {
        self.outer.len()
    }

    fn evaluate(&self, noise: &[f64], order: Order) -> Result<Energy, InferenceError> {
        let whole = self.inner_fit(noise)?;
        let energy = self.posterior.evaluate(&whole, Order::Second)?;
        let inner_hessian = energy.hessian.select(&self.inner);
        let mean: Vec<f64> = self.inner.iter().map(|&i| whole[i]).collect();
        let gaussian = Gaussian::from_hessian(&mean, energy.value, &inner_hessian)
            .map_err(|_| InferenceError::NotFinite { value: f64::NAN, at: whole.clone() })?;
        let mut out = Energy { value: -gaussian.ln_integral, ..Energy::default() };
        if order == Order::Value {
            return Ok(out);
        }
        let factor = Cholesky::new(&inner_hessian)?;
        let inverse = factor.inverse();
        for &u in &self.outer {
            // The maximum moves with the noise: dz/du = -A^-1 d2J/dz du.
            let cross: Vec<f64> = self.inner.iter().map(|&i| energy.hessian[(i, u)]).collect();
            let mut direction = vec![0.0; whole.len()];
            direction[u] = 1.0;
            for (&i, d) in self.inner.iter().zip(factor.solve(&cross)) {
                direction[i] = -d;
            }
            let difference = |h: f64| -> Result<Matrix, InferenceError> {
                let forward = self.hessian_along(&whole, &direction, h)?;
                Ok(forward.plus(-1.0, &self.hessian_along(&whole, &direction, -h)?))
            };
            let (near, far) = (difference(STEP)?, difference(2.0 * STEP)?);
            let n = self.inner.len();
            let trace: f64 = (0..n)
                .flat_map(|i| (0..n).map(move |j| (i, j)))
                .map(|(i, j)| inverse[(i, j)] * (8.0 * near[(i, j)] - far[(i, j)]) / (12.0 * STEP))
                .sum();
            out.gradient.push(energy.gradient[u] + 0.5 * trace);
        }
        Ok(out)
    }
}
