//! Results as files: one record per fitted model, as JSON.

use super::assess::Assessment;
use super::health::Health;
use crate::density::{Calls, Stop};
use crate::evidence::{Evidence, Laplace};
use crate::fit::NoiseEstimate;
use crate::problem::{Parameters, Prior};
use rijke_numerics::Matrix;
use serde::{Deserialize, Serialize};

/// Everything that an inference found of one model, ready to be written as JSON by serde.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InferenceRecord {
    /// Name of the model.
    pub model: String,
    /// One entry per parameter, in the order of the covariance.
    pub parameters: Vec<ParameterRecord>,
    /// Posterior covariance of the physical parameters, row by row; empty if Laplace's method did not apply.
    pub covariance: Vec<Vec<f64>>,
    /// Standard deviations of the noise.
    pub noise: Vec<NoiseEstimate>,
    /// Evidence summed over all maxima, nats, or why there is none.
    pub evidence: Result<Evidence, String>,
    /// Size of the second-derivative part of the Hessian relative to the rest of it.
    pub curvature_ratio: Option<f64>,
    /// Distance of the BFGS matrix from the Hessian, if BFGS was used.
    pub bfgs_distance: Option<f64>,
    /// What the checks of the evidence found.
    pub health: Health,
    /// Why the search ended.
    pub stop: Stop,
    /// Calls of the model in the best fit.
    pub calls: Calls,
}

/// One parameter of a [`InferenceRecord`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParameterRecord {
    /// Name.
    pub name: String,
    /// Symbol in print.
    pub symbol: String,
    /// Unit.
    pub unit: String,
    /// Prior.
    pub prior: Prior,
    /// Most probable physical value (at the maximum in the working coordinates).
    pub value: f64,
    /// Posterior standard deviation, to first order in the transform.
    pub sd: Option<f64>,
}

impl InferenceRecord {
    /// Collects what `assessment` found of the model called `model`.
    #[must_use]
    pub fn new(model: &str, parameters: &Parameters, assessment: &Assessment) -> Self {
        let laplace = assessment.laplace.as_ref();
        let sds = laplace.map(Laplace::sd).ok();
        let rows = parameters.list().iter().enumerate().map(|(i, q)| ParameterRecord {
            name: q.name.clone(),
            symbol: q.symbol.clone(),
            unit: q.unit.clone(),
            prior: q.prior,
            value: assessment.fit.parameters[i],
            sd: sds.as_ref().map(|s| s[i]),
        });
        Self {
            model: model.to_owned(),
            parameters: rows.collect(),
            covariance: laplace.map(|l| rows_of(&l.physical_covariance)).unwrap_or_default(),
            noise: assessment.fit.noise.clone(),
            evidence: assessment.evidence.clone(),
            curvature_ratio: laplace.ok().map(Laplace::curvature_ratio),
            bfgs_distance: laplace.ok().and_then(|l| l.bfgs_distance),
            health: assessment.health.clone(),
            stop: assessment.fit.stop.clone(),
            calls: assessment.fit.calls,
        }
    }
}

fn rows_of(matrix: &Matrix) -> Vec<Vec<f64>> {
    (0..matrix.rows()).map(|i| matrix.row(i).to_vec()).collect()
}
