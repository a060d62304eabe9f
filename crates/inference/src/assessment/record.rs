//! Results as files: one record per fitted model, as JSON, and draws for Python.

use super::assess::Assessment;
use super::health::Health;
use crate::density::{Calls, Gaussian, Stop};
use crate::error::InferenceError;
use crate::evidence::{Evidence, Laplace};
use crate::fit::NoiseEstimate;
use crate::problem::{Parameters, Prior};
use rand::RngExt;
use rand_distr::StandardNormal;
use rijke_numerics::{Matrix, Streams};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

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
    /// Posterior standard deviation ([`Parameter::sd_about`](crate::Parameter::sd_about)), wider by what
    /// few data leave unknown of the noise.
    pub sd: Option<f64>,
}

/// Draws in the layout of `arviz.from_json`: group, then variable, then chain by draw.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Draws {
    /// Draws of each physical parameter by name, one chain.
    pub posterior: BTreeMap<String, [Vec<f64>; 1]>,
    /// The method, for the reader.
    pub posterior_attrs: BTreeMap<String, String>,
}

impl InferenceRecord {
    /// Collects what `assessment` found of the model called `model`; `few` has for each parameter the
    /// factor on its standard deviation that few data ask for ([`Few`](crate::Few)).
    #[must_use]
    pub fn new(model: &str, parameters: &Parameters, assessment: &Assessment, few: &[f64]) -> Self {
        let laplace = assessment.laplace.as_ref();
        let sds = laplace.map(Laplace::sd).ok();
        let wider = |l: &Laplace| {
            let (c, p) = (&l.physical_covariance, few.len());
            rows_of(&Matrix::from_fn(p, p, |i, j| few[i] * c[(i, j)] * few[j]))
        };
        let rows = parameters.list().iter().enumerate().map(|(i, q)| ParameterRecord {
            name: q.name.clone(),
            symbol: q.symbol.clone(),
            unit: q.unit.clone(),
            prior: q.prior,
            value: assessment.fit.parameters[i],
            sd: sds.as_ref().map(|s| few[i] * s[i]),
        });
        Self {
            model: model.to_owned(),
            parameters: rows.collect(),
            covariance: laplace.map(wider).unwrap_or_default(),
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

impl Draws {
    /// `count` draws from Laplace's Gaussian, `few` times as wide, as physical values.
    ///
    /// # Errors
    /// [`InferenceError::Dense`] if the Hessian is not positive definite.
    pub fn new(
        parameters: &Parameters,
        laplace: &Laplace,
        few: &[f64],
        count: usize,
        streams: Streams,
    ) -> Result<Self, InferenceError> {
        let gaussian = Gaussian::from_hessian(&laplace.mean, 0.0, &laplace.hessian)?;
        let mut stream = streams.stream("inference/draws");
        let points: Vec<Vec<f64>> = (0..count)
            .map(|_| {
                let xi: Vec<f64> = (0..laplace.mean.len()).map(|_| stream.sample(StandardNormal)).collect();
                let wider = gaussian.point(&xi).into_iter().zip(&laplace.mean).zip(few);
                parameters
                    .physical(&wider.map(|((z, mean), few)| mean + few * (z - mean)).collect::<Vec<_>>())
            })
            .collect();
        let posterior = parameters
            .list()
            .iter()
            .enumerate()
            .map(|(i, p)| (p.name.clone(), [points.iter().map(|a| a[i]).collect()]))
            .collect();
        let method = [("method".to_owned(), "Laplace".to_owned())];
        Ok(Self { posterior, posterior_attrs: method.into_iter().collect() })
    }
}

fn rows_of(matrix: &Matrix) -> Vec<Vec<f64>> {
    (0..matrix.rows()).map(|i| matrix.row(i).to_vec()).collect()
}
