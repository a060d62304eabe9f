//! The rows of a stage's table: which candidates make each model, and what training finds of it.

use super::course::{Choice, Chosen, Found, Run, StandsOn, Trusted};
use super::doubts::{doubts, feeding};
use super::matching::check_modes;
use super::record::{EvidenceRecord, ModelRecord, misfit, parameters};
use crate::noise::{Noise, floats, measured_sd};
use crate::{Assembly, EngineError, Knowledge, Misfit, PointModel, Training, train};
use rijke_inference::{AssessOptions, MapOptions, Parameter, TrustRegion};
use rijke_network::Workspace;
use rijke_numerics::{Order, Streams};
use rijke_study::plan::Stage;
use rijke_study::{Candidate, Effect, Study};
use std::collections::BTreeMap;
use std::sync::Arc;

/// One row of a table.
#[derive(Default)]
pub(super) struct Row {
    /// The candidates in question.
    pub(super) own: Vec<Candidate>,
    pub(super) choice: Choice,
}

impl Row {
    /// What the table calls it.
    pub(super) fn id(&self) -> String {
        self.own.iter().map(|c| c.id.as_str()).collect::<Vec<_>>().join(" + ")
    }
}

/// The rows of the table of a stage; `before` is what each earlier stage chose.
pub(super) fn rows_of(study: &Study, stage: &Stage, before: &dyn Fn(&str) -> Option<Choice>) -> Vec<Row> {
    let catalogue = &study.catalogue;
    // What it takes from stages before it, and what it names itself.
    let mut base = Choice::new();
    stage.on.iter().filter_map(|id| before(id)).for_each(|choice| base.extend(choice));
    base.retain(|role, _| !stage.without.contains(role));
    base.extend(stage.with.clone());
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
    let row = |own: Vec<Candidate>| Row { choice: with_candidates(base.clone(), &own), own };
    lists.into_iter().filter(possible).map(row).collect()
}

/// The model of one candidate per role.
pub(super) fn assembly_of(
    study: &Study,
    choice: &Choice,
    hold: &BTreeMap<String, f64>,
) -> Result<Assembly, EngineError> {
    let candidates = choice.values().filter_map(|id| study.catalogue.get(id).cloned()).collect();
    Assembly::new(Arc::new(study.rig.clone()), candidates, hold)
}

impl Run {
    /// The rows of the table of a stage.
    pub(super) fn rows(&self, stage: &Stage) -> Vec<Row> {
        rows_of(&self.study, stage, &|id| self.stage_done(id).map(|done| done.choice.clone()))
    }

    /// Trains a row; a row that cannot be fitted has no evidence.
    pub(super) fn row(
        &self,
        stage: &Stage,
        row: &Row,
        stands_on: StandsOn,
        trusted: Trusted,
    ) -> Result<Found, EngineError> {
        self.go_on()?;
        let effects = row.own.iter().flat_map(|c| &c.effects);
        let law =
            |e: &Effect| (format!("{} at {}", e.coefficient.name(), e.place_text), e.law.source().to_owned());
        let mut record = ModelRecord {
            id: row.id(),
            label: if row.own.is_empty() {
                "the rig as rig.toml describes it".to_owned()
            } else {
                row.own.iter().map(|c| c.name.as_str()).collect::<Vec<_>>().join("; ")
            },
            candidates: row.choice.clone(),
            laws: effects.map(law).collect(),
            parameters: Vec::new(),
            misfit: [0.0; 3],
            evidence: None,
            predicted: Vec::new(),
            remark: None,
        };
        let found = match self.train_row(stage, row, stands_on, trusted) {
            Ok(found) => found,
            Err(error) => {
                record.remark = Some(error.to_string());
                return Ok((record, None));
            }
        };
        let Chosen { assembly, trained, .. } = &found;
        record.evidence = Some(EvidenceRecord::of(trained));
        record.parameters = parameters(trained, assembly.parameters());
        record.misfit = misfit(trained);
        let values = &trained.values[..trained.own];
        record.predicted = found
            .observed
            .iter()
            .map(|o| {
                let model = PointModel::new(assembly, &o.conditions, self.reference().as_slice())?
                    .starting_from(o.near);
                let s = model.respond(values, Order::Value, &mut Workspace::default())?.s.value();
                Ok([s.re, s.im])
            })
            .collect::<Result<_, EngineError>>()?;
        let reflections = found.observed.iter().zip(&record.predicted).filter_map(|(o, [_, omega])| {
            let model = PointModel::new(assembly, &o.conditions, &[]).ok()?;
            Some((model.end_reflections(values, *omega), *omega))
        });
        let said: Vec<String> =
            trained.referee.iter().map(ToString::to_string).chain(feeding(reflections)).collect();
        let doubts = doubts(&found.observed, &record.predicted, record.misfit, floats(&trained.noise));
        let remarks: Vec<String> = trained.warnings.iter().cloned().chain(said).chain(doubts).collect();
        record.remark = Some(remarks.join("; ")).filter(|w| !w.is_empty());
        Ok((record, Some(found)))
    }

    /// The microphones that a stage uses.
    pub(super) fn microphones(&self, stage: &Stage) -> Vec<usize> {
        let names = &self.rig.microphones.names;
        (0..names.len()).filter(|m| stage.hears(&names[*m])).collect()
    }

    /// The microphone to which pressures are relative, if there is one.
    pub(super) fn reference(&self) -> Option<usize> {
        Some(self.rig.microphones.reference).filter(|_| !self.rig.microphones.at.is_empty())
    }

    pub(super) fn train_row(
        &self,
        stage: &Stage,
        row: &Row,
        StandsOn { known, points }: StandsOn,
        trusted: Trusted,
    ) -> Result<Chosen, EngineError> {
        let assembly = assembly_of(&self.study, &row.choice, &stage.hold)?;
        let mut training = self.training(stage, self.noise(&stage.noise)?, known.to_vec(), trusted);
        if let Some(found) = self.near.get(&[stage.id.clone(), row.id()]) {
            let value = |p: &Parameter| {
                let same = found.iter().find(|q| q.name == p.name);
                same.map_or_else(|| p.prior.quantile(0.5), |q| q.value)
            };
            training.search.start = Some(assembly.parameters().iter().map(value).collect());
        }
        let trained = match train(&assembly, &points, &training) {
            Ok(trained) => trained,
            // If the rig as described has other modes, that is the reason, and not where the search then
            // stopped.
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
            observed: points,
            known,
            misfit,
        })
    }

    pub(super) fn training(
        &self,
        stage: &Stage,
        noise: Noise,
        known: Vec<Knowledge>,
        trusted: Trusted,
    ) -> Training {
        let search = gauss_newton();
        let referee = if let Trusted::Refereed(kind, error) = trusted { Some((kind, error)) } else { None };
        let usual = AssessOptions {
            search: search.search,
            // One stream per candidate: a further row must not change the others.
            streams: Streams::new(u64::from_le_bytes(*b"evidence")),
            referee,
            ..AssessOptions::default()
        };
        let checks = match trusted {
            Trusted::Laplace => None,
            Trusted::Searched => {
                Some(AssessOptions { random_starts: 2, screened: 16, most_starts: 8, draws: 0, ..usual })
            }
            Trusted::Checked | Trusted::Refereed(..) => Some(usual),
        };
        Training {
            microphones: self.microphones(stage),
            noise,
            known,
            channels: self.channels.clone().filter(|_| stage.channels),
            search,
            base_errors: stage.base_errors,
            checks,
        }
    }
}

/// A model with some candidates in the places of others.
pub(super) fn with_candidates(mut choice: Choice, own: &[Candidate]) -> Choice {
    for candidate in own {
        if let Some(extended) = &candidate.extends {
            choice.retain(|_, id| id != extended);
        }
        choice.insert(candidate.role.clone(), candidate.id.clone());
    }
    choice
}

/// Newton's search, done with Gauss and Newton's matrix, to 1e-5 posterior standard deviations.
fn gauss_newton() -> MapOptions {
    let options = MapOptions::default();
    MapOptions { search: TrustRegion { tolerance: 1e-10, ..options.search }, ..options }
}
