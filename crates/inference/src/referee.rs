//! Referees: slow ways to the evidence and the posterior that do not rest on Laplace's approximation.

use crate::woodbury::Factor;
use crate::{Calls, Fit, InferenceError, Nested, NoiseMode, Posterior};
use rijke_numerics::{Order, Streams};
use serde::{Deserialize, Serialize};

/// A way to the evidence that needs no Gaussian approximation. Object safe.
pub trait Referee: Sync {
    /// Name in tables.
    fn name(&self) -> &'static str;

    /// Integrates `target`.
    ///
    /// # Errors
    /// Errors of the target that are not recoverable; recoverable ones count as probability zero.
    fn judge(&self, target: &dyn Target) -> Result<Judged, InferenceError>;
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

/// What a referee found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Judged {
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

/// The likelihood of a posterior whose floated noise is held at its value in a fit: the same evidence that Laplace's
/// method approximates. Priors must be proper.
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
        let inferred: Vec<_> = posterior
            .floating()
            .iter()
            .enumerate()
            .filter_map(|(k, &g)| match posterior.data().groups()[g].mode {
                NoiseMode::Inferred { median, ln_sd } => Some((p + k, median.ln(), ln_sd)),
                _ => None,
            })
            .collect();
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
            return Err(InferenceError::NotFinite { value: parts.ln_likelihood, at: z });
        }
        Ok((parts.ln_likelihood, gradient))
    }

    fn working(&self, xi: &[f64]) -> Vec<f64> {
        let (p, z) = (self.posterior.parameters().len(), self.filled(xi));
        (0..p).chain(self.inferred.iter().map(|i| i.0)).map(|i| z[i]).collect()
    }
}

/// What a referee said of one evidence.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// Which referee.
    pub referee: String,
    /// ln of the evidence, nats.
    pub ln_marginal: f64,
    /// Its statistical error as the referee states it, nats.
    pub standard_error: f64,
    /// Calls of the model.
    pub calls: usize,
    /// False if the cap on evaluations came first.
    pub finished: bool,
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { referee, ln_marginal, standard_error, calls, finished } = self;
        let end = if *finished { "" } else { ", not finished" };
        write!(f, "{referee}: ln ML {ln_marginal:.3} +- {standard_error:.3} nats, {calls} model calls{end}")
    }
}

/// The referees by name, for those who choose one at run time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RefereeKind {
    /// Nested sampling.
    Nested,
    /// NUTS with bridge sampling; needs the feature `nuts`.
    Nuts,
}

impl RefereeKind {
    /// The referee for a statistical error of about `error` nats, for a fit whose Occam factor is `ln_occam`.
    ///
    /// # Errors
    /// [`InferenceError::Referee`] if it is not part of this build.
    pub fn build(
        self,
        error: f64,
        ln_occam: f64,
        parameters: usize,
        streams: Streams,
    ) -> Result<Box<dyn Referee>, InferenceError> {
        match self {
            Self::Nested => Ok(Box::new(Nested::with_error(error, -ln_occam, parameters, streams))),
            #[cfg(feature = "nuts")]
            Self::Nuts => Ok(Box::new(crate::Nuts::with_error(error, streams))),
            #[cfg(not(feature = "nuts"))]
            Self::Nuts => Err(InferenceError::Referee {
                referee: "the gradient sampler",
                problem: "this program was built without it; build with `--features nuts`".to_owned(),
            }),
        }
    }
}
