//! Samplers: slow ways to the evidence and the posterior that do not rest on Laplace's approximation.

use crate::density::Calls;
use crate::error::InferenceError;
use serde::{Deserialize, Serialize};

/// A way to the evidence that needs no Gaussian approximation. Object safe.
pub trait Sampler: Sync {
    /// Name in tables.
    fn name(&self) -> &'static str;

    /// Integrates `target`.
    ///
    /// # Errors
    /// Errors of the target that are not recoverable; recoverable ones count as probability zero.
    fn integrate(&self, target: &dyn Target) -> Result<Integrated, InferenceError>;
}

/// A likelihood over a prior that is a standard normal in every coordinate xi.
pub trait Target: Sync {
    /// Number of coordinates.
    fn size(&self) -> usize;

    /// ln of the likelihood at `xi`.
    ///
    /// # Errors
    /// Recoverable where the model has no answer.
    fn ln_likelihood(&self, xi: &[f64]) -> Result<f64, InferenceError>;

    /// ln of the likelihood at `xi` and its gradient there.
    ///
    /// # Errors
    /// As [`Target::ln_likelihood`].
    fn gradient(&self, xi: &[f64]) -> Result<(f64, Vec<f64>), InferenceError>;

    /// The working coordinates that belong to `xi`.
    fn working(&self, xi: &[f64]) -> Vec<f64>;
}

/// What a sampler found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Integrated {
    /// ln of the evidence, nats.
    pub ln_marginal: f64,
    /// Its statistical error as the method states it, nats.
    pub standard_error: f64,
    /// Information gained from the data (posterior relative to prior), nats.
    pub information: f64,
    /// Equally weighted draws of the posterior, in working coordinates.
    pub draws: Vec<Vec<f64>>,
    /// False if the cap on evaluations came first.
    pub finished: bool,
    /// Calls of the model.
    pub calls: Calls,
}

/// What a sampler said of one evidence.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Which sampler.
    pub sampler: String,
    /// ln of the evidence, nats.
    pub ln_marginal: f64,
    /// Its statistical error as the sampler states it, nats.
    pub standard_error: f64,
    /// Calls of the model.
    pub calls: usize,
    /// False if the cap on evaluations came first.
    pub finished: bool,
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { sampler, ln_marginal, standard_error, calls, finished } = self;
        let end = if *finished { "" } else { ", not finished" };
        write!(f, "{sampler}: ln ML {ln_marginal:.3} +- {standard_error:.3} nats, {calls} model calls{end}")
    }
}
