//! The likelihood of a posterior over its prior, as samplers integrate it.

use super::sampler::Target;
use crate::covariance::Factor;
use crate::density::Objective;
use crate::error::InferenceError;
use crate::fit::{Fit, Posterior};
use rijke_numerics::Order;

/// The likelihood of a posterior whose floated noise is held at its value in a fit: the same evidence that
/// Laplace's method approximates. Priors must be proper.
pub struct LikelihoodTarget<'a> {
    posterior: &'a Posterior<'a>,
    whole: Vec<f64>,
    /// Coordinate, ln median and sd of each inferred ln sd.
    inferred: Vec<(usize, f64, f64)>,
    /// Factors of all covariances, unless a noise is inferred.
    factors: Option<Vec<Factor>>,
}

impl<'a> LikelihoodTarget<'a> {
    /// The target that belongs to `fit`.
    ///
    /// # Errors
    /// [`InferenceError::Improper`].
    pub fn new(posterior: &'a Posterior<'a>, fit: &Fit) -> Result<Self, InferenceError> {
        if let Some(parameter) = posterior.parameters().improper() {
            return Err(InferenceError::Improper { parameter: parameter.name.clone() });
        }
        let p = posterior.parameters().len();
        let inferred: Vec<_> = posterior.inferred().map(|(k, median, sd)| (p + k, median.ln(), sd)).collect();
        let factors = if inferred.is_empty() { Some(posterior.factors(&fit.working)?) } else { None };
        Ok(Self { posterior, whole: fit.working.clone(), inferred, factors })
    }

    fn filled(&self, xi: &[f64]) -> Vec<f64> {
        let (p, mut z) = (self.posterior.parameters().len(), self.whole.clone());
        z[..p].copy_from_slice(&self.posterior.parameters().from_standard_normal(&xi[..p]));
        for ((coordinate, mean, sd), x) in self.inferred.iter().zip(&xi[p..]) {
            z[*coordinate] = mean + sd * x;
        }
        z
    }
}

impl Target for LikelihoodTarget<'_> {
    fn size(&self) -> usize {
        self.posterior.parameters().len() + self.inferred.len()
    }

    fn ln_likelihood(&self, xi: &[f64]) -> Result<f64, InferenceError> {
        Ok(self.posterior.parts_with(&self.filled(xi), Order::Value, self.factors.as_deref())?.ln_likelihood)
    }

    fn gradient(&self, xi: &[f64]) -> Result<(f64, Vec<f64>), InferenceError> {
        let (parameters, z) = (self.posterior.parameters(), self.filled(xi));
        let p = parameters.len();
        let parts = self.posterior.parts_with(&z, Order::First, self.factors.as_deref())?;
        // What the parts hold is the slope of -ln likelihood - ln prior.
        let prior = parameters.ln_density(&z[..p])?.gradient;
        let slopes: Vec<f64> = (0..p).map(|i| -parts.gradient[i] - prior[i]).collect();
        let mut gradient = parameters.along_standard_normal(&xi[..p], &z, &slopes)?;
        for (coordinate, mean, sd) in &self.inferred {
            let t = (z[*coordinate] - mean) / sd;
            gradient.push(sd * (t / sd - parts.gradient[*coordinate]));
        }
        if !parts.ln_likelihood.is_finite() || gradient.iter().any(|g| !g.is_finite()) {
            return Err(InferenceError::NotFinite {
                value: parts.ln_likelihood,
                at: self.posterior.named_point(&z),
            });
        }
        Ok((parts.ln_likelihood, gradient))
    }

    fn working(&self, xi: &[f64]) -> Vec<f64> {
        let (p, z) = (self.posterior.parameters().len(), self.filled(xi));
        (0..p).chain(self.inferred.iter().map(|i| i.0)).map(|i| z[i]).collect()
    }
}
