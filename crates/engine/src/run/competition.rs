//! Candidates of one role, trained on the same points and ranked; stages that stand on each other.

use super::assumed::measured_sd;
use super::inputs::{observed, selected};
use super::matching::check_modes;
use super::record::{EvidenceRecord, MeasuredRecord, ModelRecord, StageRecord, misfit, parameters};
use crate::noise::{LawError, Noise};
use crate::{Assembly, EngineError, Knowledge, Misfit, Observed, PointModel, Trained, Training, train};
use rayon::prelude::*;
use rijke_inference::{AssessOptions, MapOptions, RefereeKind, TrustRegion};
use rijke_network::Workspace;
use rijke_numerics::{Order, Streams};
use rijke_rig::ChannelErrors;
use rijke_study::plan::Stage;
use rijke_study::{Candidate, Observations, Rig, Study};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

/// How far an evidence is trusted or checked.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Trusted {
    /// Laplace's method alone.
    #[default]
    Laplace,
    /// Other starts, importance sampling and doubled priors as well: some hundred calls of the model.
    Checked,
    /// A referee too, to a statistical error in nats.
    Refereed(RefereeKind, f64),
}

/// Role and candidate: what a model consists of.
type Choice = BTreeMap<String, String>;

/// A trained model and its training, kept for the stages that stand on it.
#[derive(Clone, Debug)]
pub struct Chosen {
    /// The model.
    pub assembly: Arc<Assembly>,
    /// What training found.
    pub trained: Arc<Trained>,
    /// The observations that trained, as they were heard through the channels that earlier stages found.
    pub observed: Arc<Vec<Observed>>,
    /// The misfit, what was measured included.
    pub(super) misfit: [f64; 3],
}

/// A study with its observations, and what has been trained of it so far.
pub struct Run {
    /// The study.
    pub study: Study,
    rig: Arc<Rig>,
    observed: Vec<Observed>,
    channels: Option<ChannelErrors>,
    trusted: Trusted,
    /// What each stage chose, by its place.
    chosen: Vec<(Choice, Chosen)>,
    /// Trainings of earlier stages with other candidates than those that they chose.
    others: Mutex<BTreeMap<(usize, Choice), Chosen>>,
}

/// One row of a table.
struct Row {
    /// The candidates in question.
    own: Vec<Candidate>,
    choice: Choice,
}

impl Run {
    /// Reads what a study needs before its first stage.
    ///
    /// # Errors
    /// Those of the files; an operating point without temperature or frequency.
    pub fn new(study: Study, observations: &Observations, trusted: Trusted) -> Result<Self, EngineError> {
        let (rig, channels) = (Arc::new(study.rig.clone()), study.channels()?);
        let observed = observed(&study, observations)?;
        let others = Mutex::new(BTreeMap::new());
        Ok(Self { study, rig, observed, channels, trusted, chosen: Vec::new(), others })
    }

    /// All observations.
    #[must_use]
    pub fn observed(&self) -> &[Observed] {
        &self.observed
    }

    /// What the stage called `id` chose, once it has run.
    #[must_use]
    pub fn chosen(&self, id: &str) -> Option<&Chosen> {
        let (k, _) = self.study.plan.stage(id)?;
        self.chosen.get(k).map(|(_, chosen)| chosen)
    }

    /// Runs the next stage; none after the last.
    ///
    /// # Errors
    /// [`EngineError::NoPoint`], [`EngineError::NoWinner`], and models that cannot be assembled. One that cannot be fitted is a row
    /// without evidence.
    pub fn next_stage(&mut self) -> Result<Option<StageRecord>, EngineError> {
        let index = self.chosen.len();
        let Some(stage) = self.study.plan.stages.get(index).cloned() else { return Ok(None) };
        let base = self.base_choice(&stage)?;
        let rows = self.rows(&stage, &base)?;
        let points = self.points(index, &stage, &base)?;
        let results: Vec<(ModelRecord, Option<Chosen>)> =
            rows.par_iter().map(|row| self.row(index, &stage, row)).collect::<Result<_, _>>()?;
        let total = |m: &ModelRecord| m.evidence.map_or(f64::NEG_INFINITY, |e| e.ln_marginal);
        let best = results.iter().map(|(m, _)| total(m)).fold(f64::NEG_INFINITY, f64::max);
        let first = |lead: f64| results.iter().position(|(m, c)| c.is_some() && total(m) >= best - lead);
        let (Some(winner), Some(next)) = (first(0.0), first(stage.decides)) else {
            let remark = results.iter().find_map(|(m, _)| m.remark.clone()).unwrap_or_default();
            return Err(EngineError::NoWinner { stage: stage.id, remark });
        };
        let (winner, chosen) = (results[winner].0.id.clone(), results[next].0.id.clone());
        let (models, trained): (Vec<ModelRecord>, Vec<_>) = results.into_iter().unzip();
        if let Some(goes_on) = trained.into_iter().nth(next).flatten() {
            self.chosen.push((rows[next].choice.clone(), goes_on));
        }
        Ok(Some(StageRecord {
            id: stage.id.clone(),
            title: stage.title.clone(),
            measured: points.iter().map(MeasuredRecord::of).collect(),
            models,
            winner,
            chosen,
            decides: stage.decides,
        }))
    }

    /// The model that goes on from a stage, trained with what enters predictions but not the comparison.
    ///
    /// # Errors
    /// Those of the training.
    pub fn for_predictions(&self, id: &str) -> Result<Option<Chosen>, EngineError> {
        let (Some((index, stage)), Some(chosen)) = (self.study.plan.stage(id), self.chosen(id)) else {
            return Ok(None);
        };
        let Some(noise) = &stage.noise_of_predictions else { return Ok(Some(chosen.clone())) };
        let choice = &self.chosen[index].0;
        let known = self.known(stage, choice)?;
        let training = self.training(stage, self.noise(noise)?, known, Trusted::Laplace);
        let trained = train(&chosen.assembly, &chosen.observed, &training)?;
        Ok(Some(Chosen { trained: Arc::new(trained), ..chosen.clone() }))
    }

    /// The error of laws that enters the predictions of a stage.
    #[must_use]
    pub fn law_error(&self, id: &str) -> Option<LawError> {
        let (_, stage) = self.study.plan.stage(id)?;
        let spec = stage.noise_of_predictions.as_ref().unwrap_or(&stage.noise).law.as_ref()?;
        let over = self.study.campaign.factor(&spec.over)?;
        Some(LawError { role: spec.role.clone(), sd: spec.sd, over })
    }

    /// The candidates that a stage takes from those before it, and those that it names itself.
    fn base_choice(&self, stage: &Stage) -> Result<Choice, EngineError> {
        let mut choice = Choice::new();
        for id in &stage.on {
            if let Some((choice_of, _)) = self.study.plan.stage(id).and_then(|(k, _)| self.chosen.get(k)) {
                choice.extend(choice_of.clone());
            }
        }
        choice.retain(|role, _| !stage.without.contains(role));
        choice.extend(stage.with.clone());
        Ok(choice)
    }

    /// The rows of the table of a stage.
    fn rows(&self, stage: &Stage, base: &Choice) -> Result<Vec<Row>, EngineError> {
        let catalogue = &self.study.catalogue;
        let mut lists: Vec<Vec<Candidate>> = Vec::new();
        if !stage.compete.is_empty() {
            lists.push(Vec::new());
        }
        for role in &stage.compete {
            let named = |c: &&Candidate| stage.among.is_empty() || stage.among.contains(&c.id);
            let competing: Vec<&Candidate> = catalogue.competing(role).into_iter().filter(named).collect();
            let longer = |list: Vec<Candidate>| {
                let one = |c: &&Candidate| [list.clone(), vec![(*c).clone()]].concat();
                competing.iter().map(one).collect::<Vec<_>>()
            };
            lists = lists.into_iter().flat_map(longer).collect();
        }
        for ids in &stage.rows {
            lists.push(ids.iter().filter_map(|id| catalogue.get(id).cloned()).collect());
        }
        if lists.is_empty() {
            // A stage that trains one model: the candidates that it names, in question together.
            lists.push(stage.with.values().filter_map(|id| catalogue.get(id).cloned()).collect());
        }
        // A candidate that extends another can be part of no model without it.
        let possible = |own: &Vec<Candidate>| {
            own.iter().all(|c| c.extends.as_ref().is_none_or(|id| base.values().any(|b| b == id)))
        };
        let row = |own: Vec<Candidate>| {
            let mut choice = base.clone();
            for candidate in &own {
                if let Some(extended) = &candidate.extends {
                    choice.retain(|_, id| id != extended);
                }
                choice.insert(candidate.role.clone(), candidate.id.clone());
            }
            Row { own, choice }
        };
        Ok(lists.into_iter().filter(possible).map(row).collect())
    }

    /// The observations that train a stage, heard through the channels that earlier stages found.
    fn points(&self, index: usize, stage: &Stage, choice: &Choice) -> Result<Vec<Observed>, EngineError> {
        let mut points = selected(&self.study, &self.observed, &stage.points);
        if points.is_empty() {
            return Err(EngineError::NoPoint { stage: stage.id.clone() });
        }
        if !stage.channels {
            for id in &stage.on {
                let before = self.stage_with(id, index, choice)?;
                let known = before.trained.knowledge();
                points = points.iter().map(|o| known.without_channels(&self.rig, o)).collect();
            }
        }
        Ok(points)
    }

    /// An earlier stage, trained with the candidates of `choice` in the roles that it has.
    fn stage_with(&self, id: &str, before: usize, choice: &Choice) -> Result<Chosen, EngineError> {
        let Some((index, stage)) = self.study.plan.stage(id).filter(|(k, _)| *k < before) else {
            return Err(EngineError::NoPoint { stage: id.to_owned() });
        };
        let (usual, chosen) = &self.chosen[index];
        let mut wanted = usual.clone();
        for (role, id) in &mut wanted {
            if let Some(other) = choice.get(role) {
                id.clone_from(other);
            }
        }
        if wanted == *usual {
            return Ok(chosen.clone());
        }
        let key = (index, wanted);
        if let Some(found) = self.others.lock().ok().and_then(|others| others.get(&key).cloned()) {
            return Ok(found);
        }
        let row = Row { own: Vec::new(), choice: key.1.clone() };
        let found = self.train_row(index, stage, &row, Trusted::Laplace)?;
        if let Ok(mut others) = self.others.lock() {
            others.insert(key, found.clone());
        }
        Ok(found)
    }

    fn known(&self, stage: &Stage, choice: &Choice) -> Result<Vec<Knowledge>, EngineError> {
        let index = self.study.plan.stage(&stage.id).map_or(0, |(k, _)| k);
        stage.on.iter().map(|id| Ok(self.stage_with(id, index, choice)?.trained.knowledge())).collect()
    }

    fn training(&self, stage: &Stage, noise: Noise, known: Vec<Knowledge>, trusted: Trusted) -> Training {
        let names = &self.rig.microphones.names;
        let used = |m: &usize| stage.microphones.is_empty() || stage.microphones.contains(&names[*m]);
        let search = gauss_newton();
        let referee = if let Trusted::Refereed(kind, error) = trusted { Some((kind, error)) } else { None };
        let checks = AssessOptions {
            search: search.search,
            // One stream per candidate: a further row must not change the others.
            streams: Streams::new(u64::from_le_bytes(*b"evidence")),
            referee,
            ..AssessOptions::default()
        };
        Training {
            microphones: (0..names.len()).filter(used).collect(),
            noise,
            known,
            channels: self.channels.clone().filter(|_| stage.channels),
            search,
            base_errors: stage.base_errors,
            checks: (trusted != Trusted::Laplace).then_some(checks),
        }
    }

    fn train_row(
        &self,
        index: usize,
        stage: &Stage,
        row: &Row,
        trusted: Trusted,
    ) -> Result<Chosen, EngineError> {
        let candidates = row.choice.values().filter_map(|id| self.study.catalogue.get(id).cloned()).collect();
        let hold = &stage.hold;
        let assembly = Assembly::new(self.rig.clone(), candidates, hold)?;
        let points = self.points(index, stage, &row.choice)?;
        let known = self.known(stage, &row.choice)?;
        let training = self.training(stage, self.noise(&stage.noise)?, known, trusted);
        let trained = match train(&assembly, &points, &training) {
            Ok(trained) => trained,
            // If the rig as described has other modes, that is the reason, and not where the search then stopped.
            Err(error) => {
                return Err(check_modes(&assembly, &points, &training.known).err().unwrap_or(error));
            }
        };
        check_modes(&assembly, &points, &[trained.knowledge()])?;
        let found = Misfit::of(&trained.noise).measured;
        let misfit = [0, 1, 2].map(|k| found[k].hypot(measured_sd(&points, k)));
        Ok(Chosen {
            assembly: Arc::new(assembly),
            trained: Arc::new(trained),
            observed: Arc::new(points),
            misfit,
        })
    }

    fn row(
        &self,
        index: usize,
        stage: &Stage,
        row: &Row,
    ) -> Result<(ModelRecord, Option<Chosen>), EngineError> {
        let joined =
            |word: fn(&Candidate) -> &str, by: &str| row.own.iter().map(word).collect::<Vec<_>>().join(by);
        let effects = row.own.iter().flat_map(|c| &c.effects);
        let law = |e: &rijke_study::Effect| {
            (format!("{} at {}", e.coefficient.name(), e.place_text), e.law.source().to_owned())
        };
        let mut record = ModelRecord {
            id: joined(|c| &c.id, " + "),
            label: joined(|c| &c.name, "; "),
            candidates: row.choice.clone(),
            laws: effects.map(law).collect(),
            parameters: Vec::new(),
            misfit: [0.0; 3],
            evidence: None,
            predicted: Vec::new(),
            remark: None,
        };
        let found = match self.train_row(index, stage, row, self.trusted) {
            Ok(found) => found,
            Err(error) => {
                record.remark = Some(error.to_string());
                return Ok((record, None));
            }
        };
        let Chosen { assembly, trained, .. } = &found;
        let e = &trained.evidence;
        record.evidence = Some(EvidenceRecord {
            ln_best_fit: e.ln_best_fit,
            ln_occam: e.ln_occam,
            ln_marginal: e.ln_marginal,
            observations: e.datapoints,
        });
        record.parameters = parameters(trained, assembly.parameters());
        record.misfit = misfit(trained);
        let said = trained.referee.iter().map(ToString::to_string);
        let remarks: Vec<String> = trained.warnings.iter().cloned().chain(said).collect();
        record.remark = Some(remarks.join("; ")).filter(|w| !w.is_empty());
        let values = &trained.values[..trained.own];
        record.predicted = found
            .observed
            .iter()
            .map(|o| {
                let reference =
                    Some(self.rig.microphones.reference).filter(|_| !self.rig.microphones.at.is_empty());
                let model =
                    PointModel::new(assembly, &o.conditions, reference.as_slice())?.starting_from(o.near);
                let s = model.respond(values, Order::Value, &mut Workspace::default())?.s.value();
                Ok([s.re, s.im])
            })
            .collect::<Result<_, EngineError>>()?;
        Ok((record, Some(found)))
    }
}

/// Newton's search, done with Gauss and Newton's matrix, to 1e-5 posterior standard deviations.
fn gauss_newton() -> MapOptions {
    let options = MapOptions::default();
    MapOptions { search: TrustRegion { tolerance: 1e-10, ..options.search }, ..options }
}
