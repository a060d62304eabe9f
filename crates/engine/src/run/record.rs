//! What a stage found, as numbers that are written and drawn.

use super::found::{Checks, ExactLengths, Missing};
use super::parameter::TrainedParameter;
use crate::{Misfit, Observed, Trained};
use rijke_inference::probabilities;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A stage: its points, and its models with what training found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageRecord {
    /// Name of the stage.
    pub id: String,
    /// What it is called.
    pub title: String,
    /// The observations that trained.
    pub measured: Vec<MeasuredRecord>,
    /// The models, in the order of the table.
    pub models: Vec<ModelRecord>,
    /// The model with the most evidence.
    pub winner: String,
    /// The model that goes on: the winner, or, if the study prefers so, the first that none beats by more
    /// than `decides` nats. Later stages count where this one leaves models open.
    pub chosen: String,
    /// Nats below which a lead does not decide.
    pub decides: f64,
    /// What earlier stages took for certain, though their evidence does not decide it: all numbers here hold
    /// if it is right.
    #[serde(default)]
    pub assumes: Vec<String>,
    /// Whether one fit stands behind each evidence (`--one-start`): nothing was searched or checked.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub one_start: bool,
    /// By how much the model that goes on misses what was measured, in a sentence without its stop, if that
    /// is many errors and much.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub missed: Option<String>,
    /// Which stages of responses, on which this one stands, have a model that does not describe their data,
    /// and which parameters this stage holds far from what earlier ones found, a sentence each without its
    /// stop.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub undescribed: Vec<String>,
    /// The models that the evidence of this stage leaves open, with what the stages that stand on it make of
    /// them; none where it decides.
    #[serde(default)]
    pub carried: Vec<CarriedOn>,
    /// What the data still ask for after the model that goes on.
    #[serde(default)]
    pub missing: Option<Missing>,
    /// Where something is missing, what earlier stages found of the parameters that this one tells more
    /// narrowly, in a sentence without its stop.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub moved_since: Option<String>,
    /// What errors of lengths that the rig states without one would reverse; none where nothing leads.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lengths: Option<ExactLengths>,
    /// That model point by point.
    #[serde(default)]
    pub checks: Option<Checks>,
}

impl StageRecord {
    /// What a reader of evidences of one start should know.
    pub const ONE_START: &str = "one fit stands behind each evidence, because the stage was ranked with --one-start: other maxima were not looked for, and \
                                 the evidence was not checked";
}

/// What was measured of one mode at one point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasuredRecord {
    /// Operating point.
    pub point: String,
    /// Label of the mode, if the point has several.
    pub mode: String,
    /// Value of every factor, SI; none where it has none.
    pub factors: Vec<Option<f64>>,
    /// Growth rate, 1/s, and its standard deviation.
    pub growth_rate: Option<[f64; 2]>,
    /// Angular frequency, rad/s, and its standard deviation.
    pub angular_frequency: Option<[f64; 2]>,
}

/// One row of a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelRecord {
    /// The candidates in question, joined by ` + `.
    pub id: String,
    /// What they are called.
    pub label: String,
    /// Role and candidate: the whole model.
    pub candidates: BTreeMap<String, String>,
    /// Coefficient and place, and formula, of the candidates in question.
    pub laws: Vec<(String, String)>,
    /// The model's parameters.
    pub parameters: Vec<TrainedParameter>,
    /// Misfit that the data chose: growth rate (1/s), angular frequency (rad/s), relative pressure.
    pub misfit: [f64; 3],
    /// Evidence; none if the model could not be fitted.
    pub evidence: Option<EvidenceRecord>,
    /// Growth rate and angular frequency at every measured point, in their order.
    pub predicted: Vec<[f64; 2]>,
    /// The same with the errors that points share as training found them; empty where there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fitted: Vec<[f64; 2]>,
    /// Warnings, a line each, or why there is no evidence.
    pub remark: Option<String>,
}

/// Evidence, in nats, in total.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EvidenceRecord {
    /// ln of the best fit's likelihood.
    pub ln_best_fit: f64,
    /// ln of the Occam factor.
    pub ln_occam: f64,
    /// ln of the marginal likelihood.
    pub ln_marginal: f64,
    /// Number of observations, by which tables divide.
    pub observations: usize,
}

/// A model that the evidence of its stage leaves open, with what later stages make of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CarriedOn {
    /// The model, as the table of its stage calls it.
    pub id: String,
    /// ln evidence of its stage and of the best models of those that stand on it, nats; none where one of
    /// them has no model that could be fitted.
    pub ln_evidence: Option<f64>,
    /// The best model of every later stage if this one is right.
    pub later: Vec<CarriedStage>,
}

/// The best model of a later stage, and its parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CarriedStage {
    /// The later stage.
    pub stage: String,
    /// Its best model.
    pub model: String,
    /// What it found.
    pub parameters: Vec<TrainedParameter>,
}

impl ModelRecord {
    /// Growth rate and angular frequency at every measured point, as [`ModelRecord::fitted`] where points
    /// share errors: what the residuals are counted from.
    #[must_use]
    pub fn shown(&self) -> &[[f64; 2]] {
        if self.fitted.is_empty() { &self.predicted } else { &self.fitted }
    }

    /// ln evidence, nats; minus infinity for a model that could not be fitted.
    #[must_use]
    pub fn ln_evidence(&self) -> f64 {
        self.evidence.map_or(f64::NEG_INFINITY, |e| e.ln_marginal)
    }

    /// The lines of the remark.
    pub fn remarks(&self) -> impl Iterator<Item = &str> {
        self.remark.iter().flat_map(|remark| remark.lines())
    }
}

/// Adds lines to a remark.
pub(crate) fn add_lines(remark: &mut Option<String>, lines: impl IntoIterator<Item = String>) {
    *remark = remark.take().into_iter().chain(lines).reduce(|all, line| format!("{all}\n{line}"));
}

/// ln evidence of a model with that of later stages, if it was carried on.
pub(super) fn with_later(carried: &[CarriedOn], id: &str) -> Option<f64> {
    carried.iter().find(|c| c.id == id)?.ln_evidence
}

/// The model of most evidence beside the one called `chosen`, and by how many nats it lies behind that one;
/// none where either could not be fitted.
pub(super) fn nearest<'a>(models: &'a [ModelRecord], chosen: &str) -> Option<(&'a ModelRecord, f64)> {
    let own = models.iter().find(|m| m.id == chosen)?.evidence?.ln_marginal;
    let others = models.iter().filter(|m| m.id != chosen && m.evidence.is_some());
    others.map(|m| (m, own - m.ln_evidence())).min_by(|a, b| a.1.total_cmp(&b.1))
}

impl StageRecord {
    /// The models, the most evidence first.
    #[must_use]
    pub fn by_evidence(&self) -> Vec<&ModelRecord> {
        let mut all: Vec<&ModelRecord> = self.models.iter().collect();
        all.sort_by(|a, b| b.ln_evidence().total_cmp(&a.ln_evidence()));
        all
    }

    /// Lines of remarks that all models with evidence have, if there are several.
    #[must_use]
    pub fn remarks_of_all(&self) -> Vec<&str> {
        let all: Vec<&ModelRecord> = self.models.iter().filter(|m| m.evidence.is_some()).collect();
        let [first, _, ..] = all[..] else { return Vec::new() };
        let everywhere = |line: &&str| all.iter().all(|m| m.remarks().any(|other| other == *line));
        first.remarks().filter(everywhere).collect()
    }

    /// The models that were carried on, each with its ln evidence less that of the best of them, later stages
    /// included; none where it has none.
    #[must_use]
    pub fn carried_below_best(&self) -> Vec<(&CarriedOn, Option<f64>)> {
        let best = self.carried.iter().filter_map(|c| c.ln_evidence).fold(f64::NEG_INFINITY, f64::max);
        self.carried.iter().map(|c| (c, c.ln_evidence.map(|ln| ln - best))).collect()
    }

    /// What the data say against the model that goes on: what it stands on does not describe other data, or
    /// is not what it holds, by how much it misses these, and which of their deviations are too large or too
    /// small, a sentence each without its stop.
    #[must_use]
    pub fn doubts_of_data(&self) -> Vec<String> {
        self.undescribed
            .iter()
            .chain(&self.missed)
            .cloned()
            .chain(self.checks.iter().flat_map(Checks::doubts))
            .collect()
    }

    /// How little of what residuals have beyond their noise the missing terms explain, in a sentence without
    /// its stop; none where they explain half or more.
    #[must_use]
    pub fn unexplained(&self) -> Option<String> {
        self.checks.as_ref()?.unexplained(self.missing.as_ref()?)
    }

    /// Which models the stage leaves open without carrying them on, in a sentence; none where all open ones
    /// were carried on, or none had to be.
    #[must_use]
    pub fn not_carried(&self) -> Option<String> {
        not_carried(&self.models, &self.carried, self.decides)
    }

    /// The best other model than the one that goes on, and by how many nats it lies behind that one; none
    /// where there is no other. Of models that were carried on, the evidence of later stages counts too.
    #[must_use]
    pub fn nearest(&self) -> Option<(&ModelRecord, f64)> {
        let Some(own) = self.with_later(&self.chosen) else { return nearest(&self.models, &self.chosen) };
        let others = self.models.iter().filter(|m| m.id != self.chosen);
        let behind = others.filter_map(|m| Some((m, own - self.with_later(&m.id)?)));
        behind.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// ln evidence of a model together with that of later stages, if it was carried on.
    #[must_use]
    pub fn with_later(&self, id: &str) -> Option<f64> {
        with_later(&self.carried, id)
    }

    /// The probability of every model of the table, in its order, if all were as probable before and one of
    /// them is right; zero for one without evidence.
    #[must_use]
    pub fn probabilities(&self) -> Vec<f64> {
        probabilities(&self.models.iter().map(ModelRecord::ln_evidence).collect::<Vec<_>>())
    }
}

impl EvidenceRecord {
    pub(super) fn of(trained: &Trained) -> Self {
        let e = &trained.evidence;
        Self {
            ln_best_fit: e.ln_best_fit,
            ln_occam: e.ln_occam,
            ln_marginal: e.ln_marginal,
            observations: e.datapoints,
        }
    }

    /// ln ML per observation.
    #[must_use]
    pub fn per_observation(&self) -> [f64; 3] {
        [self.ln_best_fit, self.ln_occam, self.ln_marginal].map(|v| v / self.observations.max(1) as f64)
    }
}

impl MeasuredRecord {
    pub(super) fn of(observed: &Observed) -> Self {
        let mode = &observed.mode;
        let sd = |k: usize| mode.covariance[(k, k)].sqrt();
        let second = usize::from(mode.growth_rate.is_some());
        Self {
            point: observed.conditions.id.clone(),
            mode: mode.label.clone(),
            factors: observed
                .conditions
                .point
                .factors
                .iter()
                .map(|v| Some(*v).filter(|v| !v.is_nan()))
                .collect(),
            growth_rate: mode.growth_rate.map(|v| [v, sd(0)]),
            angular_frequency: mode.angular_frequency.map(|v| [v, sd(second)]),
        }
    }
}

pub(super) fn misfit(trained: &Trained) -> [f64; 3] {
    Misfit::of(&trained.noise).measured
}

/// As [`StageRecord::not_carried`].
pub(super) fn not_carried(models: &[ModelRecord], carried: &[CarriedOn], decides: f64) -> Option<String> {
    let best = models.iter().map(ModelRecord::ln_evidence).fold(f64::NEG_INFINITY, f64::max);
    let lost = |m: &&ModelRecord| m.ln_evidence() >= best - decides && carried.iter().all(|c| c.id != m.id);
    let mut lost: Vec<&ModelRecord> = models.iter().filter(lost).collect();
    lost.sort_by(|a, b| b.ln_evidence().total_cmp(&a.ln_evidence()));
    let (first, many) = (&lost.first()?.id, lost.len());
    (!carried.is_empty()).then(|| {
        format!(
            "{many} more {} within {decides} nats of the best and {} not carried on, because only the best {} are; the first is {first}: averages leave \
             them out, and `rijke search` weighs all",
            if many == 1 { "lies" } else { "lie" },
            if many == 1 { "was" } else { "were" },
            carried.len()
        )
    })
}
