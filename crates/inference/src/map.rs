//! The most probable parameters.

use crate::{Calls, InferenceError, Method, Posterior, Stop, TrustRegion, minimise};
use rijke_numerics::Matrix;
use serde::{Deserialize, Serialize};

/// Settings of [`Posterior::map`].
#[derive(Clone, Debug, PartialEq)]
pub struct MapOptions {
    /// The minimiser; [`Method::Bfgs`] for the paper's algorithm.
    pub search: TrustRegion,
    /// Physical parameters to start from; the centre of the prior if none.
    pub start: Option<Vec<f64>>,
}

/// The maximum of a posterior, as far as the search has come: look at `stop`.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Working coordinates: those of the parameters, then ln sd of each noise that floats.
    pub working: Vec<f64>,
    /// Physical parameters.
    pub parameters: Vec<f64>,
    /// Standard deviation of every group of noise.
    pub noise: Vec<NoiseEstimate>,
    /// J at the end, nats.
    pub cost: f64,
    /// The matrix of second derivatives of J that the search held at the end (BFGS, or exact).
    pub search_hessian: Matrix,
    /// Which of the two it is.
    pub method: Method,
    /// Why the search ended.
    pub stop: Stop,
    /// Accepted steps.
    pub steps: usize,
    /// Calls of the model.
    pub calls: Calls,
}

/// The standard deviation of one group of noise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NoiseEstimate {
    /// Name of the group.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Standard deviation, without the floor.
    pub sd: f64,
    /// True if the data chose it.
    pub floats: bool,
}

impl Default for MapOptions {
    /// Exact Newton steps from the centre of the prior.
    fn default() -> Self {
        Self { search: TrustRegion::default(), start: None }
    }
}

impl MapOptions {
    /// The paper's algorithm: BFGS with the analytic gradient.
    ///
    /// It stops at 1e-12 nats by its own matrix, about 1e-6 posterior standard deviations from the maximum.
    #[must_use]
    pub fn bfgs() -> Self {
        Self {
            search: TrustRegion { method: Method::Bfgs, tolerance: 1e-12, ..TrustRegion::default() },
            start: None,
        }
    }

    /// The same settings from another start, in physical values.
    #[must_use]
    pub fn from(self, start: &[f64]) -> Self {
        Self { start: Some(start.to_vec()), ..self }
    }
}

impl Posterior<'_> {
    /// Finds a local maximum of the posterior over parameters and floating noise.
    ///
    /// # Errors
    /// [`InferenceError::NoStart`] if the model fails at the start, and errors that are not recoverable. A search that
    /// ends without converging is a [`Fit`] whose `stop` says so.
    pub fn map(&self, options: &MapOptions) -> Result<Fit, InferenceError> {
        let start = self.start(options.start.as_deref())?;
        self.map_from(&start, &options.search)
    }

    /// As [`Posterior::map`], from working coordinates.
    ///
    /// # Errors
    /// As [`Posterior::map`].
    pub fn map_from(&self, start: &[f64], search: &TrustRegion) -> Result<Fit, InferenceError> {
        let minimum = minimise(self, start, search)?;
        let sds = self.noise_sd(&minimum.z);
        let noise = self.data().groups().iter().zip(sds).map(|(g, sd)| NoiseEstimate {
            name: g.name.clone(),
            unit: g.unit.clone(),
            sd,
            floats: g.floats(),
        });
        Ok(Fit {
            parameters: self.parameters().physical(&minimum.z),
            noise: noise.collect(),
            cost: minimum.energy.value,
            search_hessian: minimum.hessian,
            method: search.method,
            stop: minimum.stop,
            steps: minimum.steps,
            calls: minimum.calls,
            working: minimum.z,
        })
    }
}
