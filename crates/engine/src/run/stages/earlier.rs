//! What earlier stages know of a model, trained again where one of its candidates is not the one that they
//! chose.

use super::super::course::{Chosen, Elsewhere, Run, StandsOn, Trusted};
use super::maxima::combined;
use crate::rows::{Choice, Row};
use crate::{EngineError, NamedGaussian, Observed};
use rijke_study::plan::Stage;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The place of a stage, and the candidates that it is trained with.
type Key = (usize, Choice);

/// Trainings of earlier stages, each done once.
pub(in crate::run) struct Earlier<'a> {
    run: &'a Run,
    trained: BTreeMap<Key, Chosen>,
    ready: BTreeMap<Vec<Key>, StandsOn>,
}

impl<'a> Earlier<'a> {
    pub(in crate::run) fn new(run: &'a Run) -> Self {
        Self { run, trained: BTreeMap::new(), ready: BTreeMap::new() }
    }

    /// What a model of `choice` in `stage` stands on.
    pub(in crate::run) fn of(
        &mut self,
        stage: &Stage,
        choice: &Choice,
        points: &[Observed],
    ) -> Result<StandsOn, EngineError> {
        let (grounds, stages): (Vec<&String>, Vec<&String>) =
            stage.on.iter().partition(|id| self.run.ground(id).is_some());
        let on = stages.iter().map(|id| self.key(id, choice));
        // Channels are those that the stage found with the model that it chose, whatever the model here.
        let heard = stage.heard_through.iter().map(|id| self.key(id, &Choice::new()));
        let mut keys: Vec<Key> = on.chain(heard).collect::<Result<_, _>>()?;
        let trained_before = keys.len();
        let mut measured: Vec<Vec<(f64, NamedGaussian)>> = Vec::new();
        for (k, ground) in grounds.into_iter().filter_map(|id| self.run.ground(id)).enumerate() {
            let model = ground.with(choice, &stage.id)?;
            measured.push(model.maxima(&ground.id)?);
            // No place of a stage of modes.
            keys.push((usize::MAX - k, model.candidates.clone()));
        }
        if let Some(ready) = self.ready.get(&keys) {
            return Ok(ready.clone());
        }
        let trained: Vec<Chosen> =
            keys[..trained_before].iter().map(|key| self.trained(key)).collect::<Result<_, _>>()?;
        let mut points = points.to_vec();
        if !stage.channels {
            for known in trained.iter().map(|c| c.trained.gaussian()) {
                points = points.iter().map(|o| known.without_channels(&self.run.rig, o)).collect();
            }
        }
        let places = keys.iter().map(|(place, _)| *place);
        let known = places.zip(&trained).take(stages.len()).map(|(place, c)| self.by_maxima(place, c));
        let known: Vec<Vec<(f64, NamedGaussian)>> = known.chain(measured).collect();
        let ready = StandsOn { maxima: Arc::new(combined(&known)), points: Arc::new(points) };
        self.ready.insert(keys, ready.clone());
        Ok(ready)
    }

    /// What a stage knows by each maximum of its posterior, the most probable first, with its probability.
    fn by_maxima(&self, place: usize, chosen: &Chosen) -> Vec<(f64, NamedGaussian)> {
        let stage = &self.run.study.plan.stages[place];
        let there = |m: &Elsewhere| {
            let there = Chosen { known: m.known.clone(), ..chosen.clone() };
            let found = self.run.trained_again(stage, &stage.noise, &there, &chosen.observed, &m.at);
            Some((m.odds, found.ok()?.gaussian()))
        };
        let mut all = vec![(1.0, chosen.trained.gaussian())];
        all.extend(chosen.maxima.iter().filter_map(there));
        let sum: f64 = all.iter().map(|(odds, _)| odds).sum();
        all.into_iter().map(|(odds, found)| (odds / sum, found)).collect()
    }

    /// The stage `id` with the candidates of `choice` in the roles that it has.
    fn key(&self, id: &str, choice: &Choice) -> Result<Key, EngineError> {
        let found = self.run.study.plan.stage(id).and_then(|(k, _)| Some((k, self.run.done.get(k)?)));
        let Some((k, done)) = found else { return Err(EngineError::NoPoint { stage: id.to_owned() }) };
        let mut wanted = done.choice.clone();
        for (role, id) in &mut wanted {
            if let Some(other) = choice.get(role) {
                id.clone_from(other);
            }
        }
        Ok((k, wanted))
    }

    fn trained(&mut self, key: &Key) -> Result<Chosen, EngineError> {
        let (k, choice) = key;
        let done = &self.run.done[*k];
        if *choice == done.choice {
            return Ok(done.chosen.clone());
        }
        // A row of the table, with all its maxima.
        if let Some((_, chosen)) = done.rows.iter().find(|(model, _)| model.candidates == *choice) {
            return Ok(chosen.clone());
        }
        if let Some(found) = self.trained.get(key) {
            return Ok(found.clone());
        }
        let stage = &self.run.study.plan.stages[*k];
        let points =
            super::super::points::inputs::selected(&self.run.study, &self.run.observed, &stage.points);
        let stands_on = self.of(stage, choice, &points)?;
        let row = Row { own: Vec::new(), choice: choice.clone() };
        // With one start for each row of the tables, one is enough here; else other maxima are looked for.
        let trusted = match self.run.trusted {
            Trusted::Laplace => Trusted::Laplace,
            _ => Trusted::Searched,
        };
        let found = self.run.train_row(stage, &row, stands_on, trusted)?;
        self.trained.insert(key.clone(), found.clone());
        Ok(found)
    }
}
