//! What a stage of responses found, as numbers that are written and drawn.

use crate::run::{EvidenceRecord, TrainedParameter, behind_by_a_prior};
use rijke_inference::{NoiseEstimate, OtherMaximum};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A stage: its data, and its models with what training found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResponseStageRecord {
    /// Name of the stage.
    pub id: String,
    /// What it is called.
    pub title: String,
    /// The responses that trained.
    pub loads: Vec<LoadRecord>,
    /// The models, in the order of the table.
    pub models: Vec<ResponseModelRecord>,
    /// The model with the most evidence.
    pub winner: String,
    /// Nats below which a lead does not decide.
    pub decides: f64,
}

/// One response.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoadRecord {
    /// Operating point.
    pub point: String,
    /// What it is: `reflection`, `transfer` or `law`.
    pub what: String,
    /// How many numbers its file holds, used or not.
    #[serde(default)]
    pub of: usize,
    /// Frequencies, Hz.
    pub frequency_hz: Vec<f64>,
    /// Real and imaginary part.
    pub measured: Vec<[f64; 2]>,
}

/// What the responses of a stage can tell before any training.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ResponseForesight {
    /// Name of the stage.
    pub id: String,
    /// What it is called.
    pub title: String,
    /// How many responses train.
    pub responses: usize,
    /// How many complex numbers those are.
    pub numbers: usize,
    /// How many their files hold.
    pub of: usize,
    /// The standard deviation that was taken for the noise.
    pub noise: f64,
    /// The errors of factors and temperatures that count.
    pub errors: Vec<String>,
    /// The models, in the order of the table.
    pub models: Vec<ForeseenModel>,
}

/// One model of such a stage.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ForeseenModel {
    /// The candidates in question, joined by ` + `.
    pub id: String,
    /// For every parameter the standard deviation that the responses leave, over that of the prior.
    pub widths: Vec<(String, f64)>,
    /// Why there are none.
    pub remark: Option<String>,
}

/// One row of a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResponseModelRecord {
    /// The candidates in question, joined by ` + `.
    pub id: String,
    /// What they are called.
    pub label: String,
    /// Role and candidate: the whole model.
    pub candidates: BTreeMap<String, String>,
    /// The model's parameters.
    pub parameters: Vec<TrainedParameter>,
    /// How many of these, before those of channels, are errors of what the campaign and the rig state.
    #[serde(default)]
    pub errors: usize,
    /// How many of these, the last, are delays and gains of channels.
    #[serde(default)]
    pub channels: usize,
    /// Noise, misfit and sizes of the head's errors.
    pub noise: Vec<NoiseEstimate>,
    /// Evidence; none if the model could not be fitted.
    pub evidence: Option<EvidenceRecord>,
    /// Real and imaginary part by load and frequency: what the rig does.
    pub predicted: Vec<Vec<[f64; 2]>>,
    /// The same as the head hears it: with its most probable errors.
    pub heard: Vec<Vec<[f64; 2]>>,
    /// Root mean square of what is left, both parts together.
    pub residual: f64,
    /// Correlation of what is left between neighbouring frequencies.
    pub neighbours: f64,
    /// Whether what is left is larger, or correlates more, than noise and misfit would: then its error bars
    /// and its lead are too sure.
    #[serde(default)]
    pub too_sure: bool,
    /// Further maxima of the posterior, the most probable first; values and standard deviations of the
    /// parameters are those of the best alone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub maxima: Vec<OtherMaximum>,
    /// Warnings, or why there is no evidence.
    pub remark: Option<String>,
}

impl ResponseStageRecord {
    /// The models, the most evidence first.
    #[must_use]
    pub fn by_evidence(&self) -> Vec<&ResponseModelRecord> {
        let mut all: Vec<&ResponseModelRecord> = self.models.iter().collect();
        all.sort_by(|a, b| b.ln_evidence().total_cmp(&a.ln_evidence()));
        all
    }

    /// The models that a prior keeps from the first place, a sentence each.
    #[must_use]
    pub fn behind_by_a_prior(&self) -> Vec<String> {
        let all = self.models.iter().map(|m| (&*m.id, m.evidence.map(|e| e.ln_marginal), &*m.parameters));
        behind_by_a_prior(&all.collect::<Vec<_>>())
    }
}

impl ForeseenModel {
    /// A parameter that keeps more of its prior width is not told by the data: half of the variance.
    const NOT_TOLD: f64 = std::f64::consts::FRAC_1_SQRT_2;

    /// The parameters that the data would not tell, each with the share of its prior width that it keeps.
    pub fn not_told(&self) -> impl Iterator<Item = (&str, f64)> {
        let all = self.widths.iter().map(|(name, width)| (name.as_str(), *width));
        all.filter(|(_, width)| *width > Self::NOT_TOLD)
    }
}

impl ResponseModelRecord {
    /// The parameters of the model, the errors of what the campaign and the rig state, and those of the
    /// channels.
    #[must_use]
    pub fn by_kind(&self) -> (&[TrainedParameter], &[TrainedParameter], &[TrainedParameter]) {
        let (rest, channels) = self.parameters.split_at(self.parameters.len().saturating_sub(self.channels));
        let (own, errors) = rest.split_at(rest.len().saturating_sub(self.errors));
        (own, errors, channels)
    }

    /// ln of the evidence; -inf if there is none.
    #[must_use]
    pub fn ln_evidence(&self) -> f64 {
        self.evidence.map_or(f64::NEG_INFINITY, |e| e.ln_marginal)
    }
}
