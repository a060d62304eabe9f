//! A posterior as a function of some of its coordinates.

use super::posterior::Posterior;
use crate::covariance::Factor;
use crate::density::{Energy, Objective};
use crate::error::InferenceError;
use crate::problem::NoiseMode;
use rijke_numerics::Order;

/// The posterior with all coordinates held but those that are `free`.
pub(crate) struct Conditional<'a> {
    pub(crate) posterior: &'a Posterior<'a>,
    /// A value for every coordinate; those of the free ones are not read.
    pub(crate) whole: Vec<f64>,
    pub(crate) free: Vec<usize>,
    /// Factors of all covariances, if no noise is free.
    factors: Option<Vec<Factor>>,
}

impl<'a> Conditional<'a> {
    pub(crate) fn new(posterior: &'a Posterior<'a>, whole: Vec<f64>, free: Vec<usize>) -> Self {
        let floats = free.iter().any(|i| *i >= posterior.parameters().len());
        // A covariance that cannot be factored says so at every evaluation.
        let factors = if floats { None } else { posterior.factors(&whole).ok() };
        Self { posterior, whole, free, factors }
    }

    /// All coordinates, with `z` in the free ones.
    pub(crate) fn filled(&self, z: &[f64]) -> Vec<f64> {
        let mut whole = self.whole.clone();
        for (&i, &v) in self.free.iter().zip(z) {
            whole[i] = v;
        }
        whole
    }
}

impl Objective for Conditional<'_> {
    fn size(&self) -> usize {
        self.free.len()
    }

    fn evaluate(&self, z: &[f64], order: Order) -> Result<Energy, InferenceError> {
        let mut energy = self.posterior.energy(&self.filled(z), order, self.factors.as_deref())?;
        if order >= Order::First {
            energy.gradient = self.free.iter().map(|&i| energy.gradient[i]).collect();
        }
        if order == Order::Second {
            energy.hessian = energy.hessian.select(&self.free);
        }
        energy.gauss_newton = energy.gauss_newton.map(|g| g.select(&self.free));
        Ok(energy)
    }

    fn named_point(&self, z: &[f64]) -> String {
        self.posterior.named_point(&self.filled(z))
    }

    fn scales(&self) -> Vec<f64> {
        let scales = self.posterior.scales();
        self.free.iter().map(|&i| scales[i]).collect()
    }
}

impl Posterior<'_> {
    /// The coordinates that an evidence integrates over: the parameters and inferred, but not floated, noise.
    pub(crate) fn integrated(&self) -> Vec<usize> {
        let p = self.parameters().len();
        (0..p).chain(self.inferred().map(|(k, ..)| p + k)).collect()
    }

    /// The inferred among the floating noises: place there, median and ln sd of its prior.
    pub(crate) fn inferred(&self) -> impl Iterator<Item = (usize, f64, f64)> {
        self.floating().iter().enumerate().filter_map(|(k, &g)| match self.data().groups()[g].mode {
            NoiseMode::Inferred { median, ln_sd } => Some((k, median, ln_sd)),
            _ => None,
        })
    }
}
