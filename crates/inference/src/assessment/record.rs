//! Results as files: one record per fitted model, as JSON and CSV, and draws for Python.

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
    /// Posterior standard deviation, to first order in the transform.
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

    /// The parameters as CSV text with a header line: name, symbol, unit, value, sd.
    #[must_use]
    pub fn parameters_csv(&self) -> String {
        let mut text = "name,symbol,unit,value,sd\n".to_owned();
        for p in &self.parameters {
            let sd = p.sd.map(|s| s.to_string()).unwrap_or_default();
            let words = [&p.name, &p.symbol, &p.unit].map(|w| quoted(w)).join(",");
            text.push_str(&format!("{words},{},{sd}\n", p.value));
        }
        text
    }
}

/// Records as CSV text, one line per model: evidence in total and per datapoint, the corrected evidence, the
/// verdict.
#[must_use]
pub fn evidence_csv(records: &[InferenceRecord]) -> String {
    let mut text = "model,parameters,datapoints,ln_best_fit_nats,ln_occam_nats,ln_marginal_nats,\
                    ln_best_fit_per_datapoint,ln_occam_per_datapoint,ln_marginal_per_datapoint,\
                    ln_marginal_corrected_nats,corrected_standard_error_nats,k_hat,verdict\n"
        .to_owned();
    for record in records {
        let numbers = match &record.evidence {
            Ok(e) => [e.ln_best_fit, e.ln_occam, e.ln_marginal]
                .into_iter()
                .chain(e.per_datapoint())
                .map(|v| v.to_string())
                .collect::<Vec<_>>()
                .join(","),
            Err(_) => ",".repeat(5),
        };
        let datapoints = record.evidence.as_ref().map(|e| e.datapoints.to_string()).unwrap_or_default();
        let check = record
            .health
            .importance
            .map_or(",,".to_owned(), |i| format!("{},{},{}", i.ln_marginal, i.standard_error, i.k_hat));
        let verdict = match &record.evidence {
            Err(reason) => reason.clone(),
            Ok(_) if record.health.warnings.is_empty() => "trusted".to_owned(),
            Ok(_) => record.health.warnings.join("; "),
        };
        let (name, verdict) = (quoted(&record.model), quoted(&verdict));
        text.push_str(&format!(
            "{name},{},{datapoints},{numbers},{check},{verdict}\n",
            record.parameters.len()
        ));
    }
    text
}

impl Draws {
    /// `count` draws from Laplace's Gaussian, as physical values.
    ///
    /// # Errors
    /// [`InferenceError::Dense`] if the Hessian is not positive definite.
    pub fn new(
        parameters: &Parameters,
        laplace: &Laplace,
        count: usize,
        streams: Streams,
    ) -> Result<Self, InferenceError> {
        let gaussian = Gaussian::from_hessian(&laplace.mean, 0.0, &laplace.hessian)?;
        let mut stream = streams.stream("inference/draws");
        let points: Vec<Vec<f64>> = (0..count)
            .map(|_| {
                let xi: Vec<f64> = (0..laplace.mean.len()).map(|_| stream.sample(StandardNormal)).collect();
                parameters.physical(&gaussian.point(&xi)[..parameters.len()])
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

/// A CSV field: in quotes if it holds a comma, a quote or a line break (RFC 4180).
fn quoted(word: &str) -> String {
    if word.contains([',', '"', '\n']) {
        format!("\"{}\"", word.replace('"', "\"\""))
    } else {
        word.to_owned()
    }
}
