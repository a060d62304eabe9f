//! Candidates that compete on the same points; stages that stand on each other.

use super::earlier::Earlier;
use super::inputs::{ambient_of_all, left_out, observed, selected, states_and_heat};
use super::record::{MeasuredRecord, ModelRecord, StageRecord, nearest};
use super::rows::{Choice, Row};
use crate::{Assembly, EngineError, Knowledge, Observed, Trained};
use rayon::prelude::*;
use rijke_inference::RefereeKind;
use rijke_rig::ChannelErrors;
use rijke_study::plan::{Prefer, Stage};
use rijke_study::{BaseState, HeatedFit, Observations, Rig, Study};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

/// How far an evidence is trusted or checked.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Trusted {
    /// Laplace's method at one maximum.
    #[default]
    Laplace,
    /// Other maxima are looked for; the evidence is summed over them and not checked.
    Searched,
    /// Other starts, importance sampling and doubled priors as well: some hundred calls of the model.
    Checked,
    /// A referee too, to a statistical error in nats.
    Refereed(RefereeKind, f64),
}

/// Rows within so many nats of the best are checked. Of others a few more maxima are looked for first: a delay whose prior lies at an alias
/// has been seen to cost 316 nats.
pub(super) const CONTENDS: f64 = 150.0;

/// A trained model and its training, kept for the stages that stand on it.
#[derive(Clone, Debug)]
pub struct Chosen {
    /// The model.
    pub assembly: Arc<Assembly>,
    /// What training found.
    pub trained: Arc<Trained>,
    /// The observations that trained, as they were heard through the channels that earlier stages found.
    pub observed: Arc<Vec<Observed>>,
    /// What earlier stages knew of it.
    pub(super) known: Arc<Vec<Knowledge>>,
    /// The misfit, what was measured included.
    pub(super) misfit: [f64; 3],
}

/// A stage that has run.
pub(super) struct Done {
    /// The model that goes on: its candidates, and what training found.
    pub(super) choice: Choice,
    pub(super) chosen: Chosen,
    /// Every row of the table that could be fitted.
    pub(super) rows: Vec<(ModelRecord, Chosen)>,
    /// What its model takes for certain, though the evidence of this stage or of those before it does not decide it.
    pub(super) assumes: Vec<String>,
}

/// What is taken for certain if the model called `taken` goes on: a sentence that names the other model that is as good, if there is one.
fn undecided(title: &str, models: &[ModelRecord], taken: &str, decides: f64) -> Option<String> {
    let (other, behind) = nearest(models, taken).filter(|(_, behind)| *behind < decides)?;
    let lies = if behind < 0.0 { "ahead" } else { "behind" };
    Some(format!("{title}: {taken} is taken, though {} is only {:.1} nats {lies}", other.id, behind.abs()))
}

impl Done {
    /// The best model of the table but the one that goes on.
    pub(super) fn rival(&self) -> Option<&(ModelRecord, Chosen)> {
        let others = self.rows.iter().filter(|(model, _)| model.candidates != self.choice);
        others.max_by(|a, b| a.0.ln_evidence().total_cmp(&b.0.ln_evidence()))
    }
}

/// A study with its observations, and what has been trained of it so far.
pub struct Run {
    /// The study.
    pub study: Study,
    pub(super) rig: Arc<Rig>,
    pub(super) observed: Vec<Observed>,
    pub(super) channels: Option<ChannelErrors>,
    pub(super) trusted: Trusted,
    pub(super) done: Vec<Done>,
    /// What the readings say of the heat, where a part heats the gas.
    pub heat: Option<HeatedFit>,
    /// Observed points that no stage uses because nothing is known of their gas.
    pub left_out: Vec<String>,
    /// States of the gas that were inferred, by the place of their point, and what is known of the temperature at each.
    pub(super) states: BTreeMap<usize, BaseState>,
    pub(super) ambient: Vec<Option<[f64; 2]>>,
    /// Models trained with what enters predictions but not the comparison, by stage.
    pub(super) predicting: Mutex<BTreeMap<String, Arc<Trained>>>,
}

impl Run {
    /// Reads what a study needs before its first stage.
    ///
    /// # Errors
    /// Those of the files; an operating point without temperature or frequency.
    pub fn new(study: Study, observations: &Observations, trusted: Trusted) -> Result<Self, EngineError> {
        let (rig, channels) = (Arc::new(study.rig.clone()), study.channels()?);
        let ambient = ambient_of_all(&study, observations);
        let (states, heat) = states_and_heat(&study, &ambient, true)?;
        let observed = observed(&study, observations, &states, &ambient)?;
        let left_out = left_out(&study, observations, &states);
        // Before anything is trained.
        let idle = |stage: &&Stage| selected(&study, &observed, &stage.points).is_empty();
        if let Some(stage) = study.plan.stages.iter().find(idle) {
            return Err(EngineError::NoPoint { stage: stage.id.clone() });
        }
        Ok(Self {
            study,
            rig,
            observed,
            channels,
            trusted,
            done: Vec::new(),
            heat,
            left_out,
            states,
            ambient,
            predicting: Mutex::default(),
        })
    }

    /// The same study with these models in the place of what its stages chose.
    pub(super) fn standing_on(&self, done: Vec<Done>) -> Self {
        Self {
            study: self.study.clone(),
            rig: self.rig.clone(),
            observed: self.observed.clone(),
            channels: self.channels.clone(),
            trusted: self.trusted,
            done,
            heat: self.heat.clone(),
            left_out: self.left_out.clone(),
            states: self.states.clone(),
            ambient: self.ambient.clone(),
            predicting: Mutex::default(),
        }
    }

    /// What the stage called `id` chose, once it has run.
    #[must_use]
    pub fn chosen(&self, id: &str) -> Option<&Chosen> {
        self.stage_done(id).map(|done| &done.chosen)
    }

    pub(super) fn stage_done(&self, id: &str) -> Option<&Done> {
        let (k, _) = self.study.plan.stage(id)?;
        self.done.get(k)
    }

    /// Runs the next stage; none after the last.
    ///
    /// # Errors
    /// [`EngineError::NoPoint`], [`EngineError::NoWinner`], and models that cannot be assembled. One that cannot be fitted is a row
    /// without evidence.
    pub fn next_stage(&mut self) -> Result<Option<StageRecord>, EngineError> {
        let Some(stage) = self.study.plan.stages.get(self.done.len()).cloned() else { return Ok(None) };
        let points = selected(&self.study, &self.observed, &stage.points);
        if points.is_empty() {
            return Err(EngineError::NoPoint { stage: stage.id });
        }
        let rows = self.rows(&stage);
        let mut earlier = Earlier::new(self);
        let known: Vec<_> = rows
            .iter()
            .map(|row| earlier.of(&stage, &row.choice, &points))
            .collect::<Result<_, EngineError>>()?;
        let mut results: Vec<(ModelRecord, Option<Chosen>)> = rows
            .par_iter()
            .zip(&known)
            .map(|(row, known)| self.row(&stage, row, known.clone(), Trusted::Laplace))
            .collect::<Result<_, _>>()?;
        let total = ModelRecord::ln_evidence;
        let best_of = |results: &[(ModelRecord, Option<Chosen>)]| {
            results.iter().map(|(m, _)| total(m)).fold(f64::NEG_INFINITY, f64::max)
        };
        if self.trusted != Trusted::Laplace {
            let best = best_of(&results);
            let contends = |m: &ModelRecord, c: &Option<Chosen>| total(m) >= best - CONTENDS || c.is_none();
            results = results
                .into_par_iter()
                .zip(rows.par_iter().zip(&known))
                .map(|((model, chosen), (row, known))| {
                    let again = |trusted| self.row(&stage, row, known.clone(), trusted);
                    if contends(&model, &chosen) {
                        return again(self.trusted);
                    }
                    let (model, chosen) = again(Trusted::Searched)?;
                    if contends(&model, &chosen) { again(self.trusted) } else { Ok((model, chosen)) }
                })
                .collect::<Result<_, EngineError>>()?;
        }
        let best = best_of(&results);
        let first = |lead: f64| results.iter().position(|(m, c)| c.is_some() && total(m) >= best - lead);
        let next = match stage.prefer {
            Prefer::Leader => first(0.0),
            Prefer::First => first(stage.decides),
        };
        let (Some(winner), Some(next)) = (first(0.0), next) else {
            let why = |(m, _): &(ModelRecord, _)| {
                Some(format!("{}: {}", if m.id.is_empty() { "it" } else { &m.id }, m.remark.clone()?))
            };
            let remark = results.iter().filter_map(why).collect::<Vec<_>>().join("\n  ");
            return Err(EngineError::NoWinner { stage: stage.id, remark });
        };
        let (winner, chosen) = (results[winner].0.id.clone(), results[next].0.id.clone());
        let models: Vec<ModelRecord> = results.iter().map(|(model, _)| model.clone()).collect();
        let Row { choice, .. } = rows.into_iter().nth(next).unwrap_or_default();
        let assumes = self.assumes(&stage);
        let own = undecided(&stage.title, &models, &chosen, stage.decides);
        if let Some(goes_on) = results[next].1.clone() {
            let rows = results.into_iter().filter_map(|(model, found)| Some((model, found?))).collect();
            let assumes = assumes.iter().cloned().chain(own).collect();
            self.done.push(Done { choice, chosen: goes_on, rows, assumes });
        }
        let (mut missing, mut checks) = (None, None);
        if let Some(done) = self.done.last() {
            missing = self.missing(&stage, &done.chosen)?;
            let rival = done.rival().map(|(model, found)| (model.id.as_str(), found));
            checks = Some(self.checks(&stage, &done.chosen, rival)?);
        }
        Ok(Some(StageRecord {
            id: stage.id,
            title: stage.title,
            measured: points.iter().map(MeasuredRecord::of).collect(),
            models,
            winner,
            chosen,
            decides: stage.decides,
            assumes,
            missing,
            checks,
        }))
    }

    /// What the stages on which `stage` stands took for certain, though their evidence does not decide it.
    fn assumes(&self, stage: &Stage) -> Vec<String> {
        let mut all: Vec<String> = Vec::new();
        for said in stage.on.iter().filter_map(|id| self.stage_done(id)).flat_map(|done| &done.assumes) {
            if !all.contains(said) {
                all.push(said.clone());
            }
        }
        all
    }
}
