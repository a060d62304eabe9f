//! The single checks of a fit: noise, doubled priors, directions that the data do not see, bounds.

use super::health::Health;
use crate::density::{Energy, Gaussian, Objective, Stop, TrustRegion, minimise};
use crate::error::InferenceError;
use crate::evidence::Laplace;
use crate::fit::{Fit, Posterior};
use crate::problem::{Coordinates, Parameters, Prior};
use rijke_numerics::words::to_digits;
use rijke_numerics::{Cholesky, Matrix, Order, symmetric_eigen};

/// ln of the standard deviation of a noise whose data tell nothing, and of how many times as large it is at
/// least.
const LOUD: [f64; 2] = [60.0, 30.0];

impl Posterior<'_> {
    /// Warns of a search that did not converge, and of noise that has too few data or none.
    pub(crate) fn warn_of_fit(&self, fit: &Fit, health: &mut Health) {
        if !fit.stop.converged() {
            let free = self.free_direction(fit).map_or(String::new(), |free| format!(": {free}"));
            health.warnings.push(format!("the search did not converge: {}{free}", fit.stop));
        }
        let data = self.data().observations();
        let told = self.told(fit);
        let mut few = Vec::new();
        for (g, noise) in fit.noise.iter().enumerate().filter(|(_, n)| n.floats) {
            let (mut size, mut count, mut bare) = (0.0_f64, 0, false);
            for observation in data {
                if let Some(structured) = &observation.structured {
                    count += structured.data_of(g);
                }
                for (_, s) in observation.noise.iter().filter(|(h, _)| *h == g) {
                    for i in (0..observation.values.len()).filter(|&i| s[(i, i)] > 0.0) {
                        size = size.max(observation.values[i].abs());
                        count += 1;
                        bare |= observation.floor.as_ref().is_none_or(|f| f[(i, i)] == 0.0);
                    }
                }
            }
            // One number alone tells no scatter.
            let few_for = |told: f64| count < 2 || (count as f64) < told + 1.0;
            if few_for(told) && self.told_by(g, fit).is_none_or(few_for) {
                few.push(format!("'{}' ({count} data)", noise.name));
            }
            if bare && noise.sd < 1e-12 * size {
                health.warnings.push(format!("the noise '{}' has collapsed to {:.1e}", noise.name, noise.sd));
            }
        }
        if !few.is_empty() {
            // Without numbers of its own, so that models of the same data say the same.
            let noise = few.join(" and ");
            health.warnings.push(format!(
                "the noise of {noise} can hardly be estimated: the parameters use up these data"
            ));
        }
    }

    /// The direction of least curvature, in deviations of the priors, where a search ended on a flat one.
    fn free_direction(&self, fit: &Fit) -> Option<String> {
        let Stop::Flat { .. } = fit.stop else { return None };
        let (h, scales) = (&fit.search_hessian, self.scales());
        let n = h.rows();
        let scaled = Matrix::from_fn(n, n, |i, j| h[(i, j)] * scales[i] * scales[j]);
        let (values, vectors) = symmetric_eigen(&scaled).ok()?;
        let lowest = (0..n).min_by(|&a, &b| values[a].total_cmp(&values[b]))?;
        let direction: Vec<f64> = (0..n).map(|i| vectors[(i, lowest)]).collect();
        Some(self.in_words(&direction, &(0..n).collect::<Vec<_>>()))
    }

    /// How many parameters the data determine: the trace of H^-1 (H - P), with H the Hessian of the cost and
    /// P that of the prior's share. A parameter that stays as its prior counts nothing. All of them where H
    /// has no inverse.
    pub(super) fn told(&self, fit: &Fit) -> f64 {
        let p = self.parameters().len();
        let own = Matrix::from_fn(p, p, |i, j| fit.search_hessian[(i, j)]);
        let found = || {
            let prior = self.parameters().ln_density(&fit.working[..p]).ok()?.hessian;
            let inverse = Cholesky::new(&own).ok()?.inverse();
            // The prior's share of the cost is -ln of its density.
            let shares = (0..p).map(|i| (0..p).map(|j| -inverse[(i, j)] * prior[(j, i)]).sum::<f64>());
            Some(shares.map(|prior| (1.0 - prior).clamp(0.0, 1.0)).sum())
        };
        found().unwrap_or(p as f64)
    }

    /// How many of these the data of one floating noise determine: the trace of H^-1 (H - G), with G the same
    /// Hessian when that noise is so large that its data tell nothing. None where H has no inverse.
    fn told_by(&self, noise: usize, fit: &Fit) -> Option<f64> {
        let p = self.parameters().len();
        let place = self.floating().iter().position(|group| *group == noise)?;
        let mut loud = fit.working.clone();
        loud[p + place] = LOUD[0].max(loud[p + place] + LOUD[1]);
        let hessian = |z: &[f64]| {
            // Where a noise floats, only the second order has the matrix of Gauss and Newton.
            let parts = self.parts(z, Order::Second).ok()?;
            Some(Matrix::from_fn(p, p, |i, j| parts.gauss_newton[(i, j)] + parts.prior[(i, j)]))
        };
        let (with, without) = (hessian(&fit.working)?, hessian(&loud)?);
        let inverse = Cholesky::new(&with).ok()?.inverse();
        let own = |i: usize| (0..p).map(|j| inverse[(i, j)] * (with[(j, i)] - without[(j, i)])).sum::<f64>();
        Some((0..p).map(own).sum())
    }

    /// The evidence with one prior widened at a time, on the quadratic model of the likelihood at the
    /// maximum.
    pub(crate) fn doubled_priors(
        &self,
        fit: &Fit,
        laplace: &Laplace,
    ) -> Result<Vec<(String, Option<f64>)>, InferenceError> {
        let p = self.parameters().len();
        let density = self.parameters().ln_density(&fit.working[..p])?;
        let n = laplace.mean.len();
        let mut surrogate = Surrogate {
            centre: laplace.mean.clone(),
            // At the maximum the slopes of likelihood and prior cancel.
            slope: (0..n).map(|i| density.gradient.get(i).copied().unwrap_or(0.0)).collect(),
            hessian: Matrix::from_fn(n, n, |i, j| {
                laplace.hessian[(i, j)] + if i < p && j < p { density.hessian[(i, j)] } else { 0.0 }
            }),
            parameters: self.parameters().clone(),
        };
        let base = Gaussian::at(&surrogate, &laplace.mean)?.ln_integral;
        let mut changes = Vec::with_capacity(p);
        for i in 0..p {
            let name = self.parameters().list()[i].name.clone();
            if let Prior::Uniform { .. } = self.parameters().list()[i].prior {
                // Twice the width halves the density; what lies beyond the old bounds was never looked at.
                changes.push((name, Some(-std::f64::consts::LN_2)));
                continue;
            }
            surrogate.parameters = self.parameters().widened(i, 2.0);
            let found = minimise(&surrogate, &laplace.mean, &TrustRegion::default())
                .and_then(|minimum| Gaussian::at(&surrogate, &minimum.z));
            changes.push((name, found.ok().map(|g| g.ln_integral - base)));
        }
        Ok(changes)
    }

    /// Directions in which the posterior keeps more than half of the prior variance.
    pub(crate) fn unidentified(&self, laplace: &Laplace) -> Result<Vec<(String, f64)>, InferenceError> {
        let keep = self.integrated();
        let scales = self.scales();
        let n = keep.len();
        let likelihood = laplace.gauss_newton.plus(1.0, &laplace.curvature);
        let scaled = Matrix::from_fn(n, n, |i, j| likelihood[(i, j)] * scales[keep[i]] * scales[keep[j]]);
        let (values, vectors) = symmetric_eigen(&scaled)?;
        Ok((0..n)
            .filter(|&k| values[k] < 1.0)
            .map(|k| {
                let direction: Vec<f64> = (0..n).map(|i| vectors[(i, k)]).collect();
                (self.in_words(&direction, &keep), 1.0 / (1.0 + values[k].max(0.0)))
            })
            .collect())
    }

    /// Parameters that sit at a bound, in words.
    pub(crate) fn at_bound(&self, fit: &Fit, laplace: &Laplace) -> Vec<String> {
        let sds = laplace.sd();
        let mut found = Vec::new();
        for (i, parameter) in self.parameters().list().iter().enumerate() {
            let ((low, high), a, z) = (parameter.prior.bounds(), fit.parameters[i], fit.working[i]);
            let near = match parameter.coordinates {
                // A Gaussian that is cut by a bound is none.
                Coordinates::Natural => a - low < sds[i] || high - a < sds[i],
                // A likelihood that is largest at a bound, or beyond it, has its maximum in these coordinates
                // at most sqrt(2) of the standard deviation there away from it.
                Coordinates::Score => {
                    let distance = (a - low).min(high - a);
                    z.abs() > FAR || (distance < CUT * sds[i] && sds[i] < NARROW * (high - low))
                }
                Coordinates::Log => false,
            };
            if near {
                let bound = if a - low < high - a { low } else { high };
                let unit = if parameter.unit == "1" { "" } else { &parameter.unit };
                let text = format!("{} = {} {unit}", parameter.name, to_digits(a, 4));
                found.push(format!("{} (bound {})", text.trim_end(), to_digits(bound, 4)));
            }
        }
        found
    }
}

/// How near to a bound, in standard deviations, and how narrow, in widths of its prior, a posterior is cut.
const CUT: f64 = 1.5;
const NARROW: f64 = 0.1;
/// A standard normal number beyond which a value sits at a bound.
const FAR: f64 = 5.0;

/// A quadratic likelihood with the exact prior of `parameters`.
struct Surrogate {
    centre: Vec<f64>,
    slope: Vec<f64>,
    hessian: Matrix,
    parameters: Parameters,
}

impl Objective for Surrogate {
    fn size(&self) -> usize {
        self.centre.len()
    }

    fn evaluate(&self, z: &[f64], _: Order) -> Result<Energy, InferenceError> {
        let (n, p) = (self.size(), self.parameters.len());
        let offset: Vec<f64> = z.iter().zip(&self.centre).map(|(z, c)| z - c).collect();
        let pull = self.hessian.times(&offset);
        let prior = self.parameters.ln_density(&z[..p])?;
        let linear: f64 = (0..n).map(|i| (self.slope[i] + 0.5 * pull[i]) * offset[i]).sum();
        let mut hessian = self.hessian.clone();
        let mut gradient: Vec<f64> = (0..n).map(|i| self.slope[i] + pull[i]).collect();
        for i in 0..p {
            gradient[i] -= prior.gradient[i];
            for j in 0..p {
                hessian[(i, j)] -= prior.hessian[(i, j)];
            }
        }
        Ok(Energy { value: linear - prior.value, gradient, hessian, gauss_newton: None })
    }
}
