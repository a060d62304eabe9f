//! The models of a search, trained, or taken from what was kept.

use super::task::Outcome;
use super::tree::settle;
use super::{Search, State, Steps, Visited};
use crate::EngineError;
use crate::rows::{Choice, Row};
use crate::run::course::{Chosen, Done, Trusted};
use crate::run::points::inputs::selected;
use crate::run::record::EvidenceRecord;
use crate::run::stages::earlier::Earlier;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::sync::Arc;

impl Search {
    pub(super) fn outcomes(
        &self,
        state: &mut State,
        level: usize,
        nodes: &[usize],
        trusted: Trusted,
        step: Steps<'_>,
    ) -> Result<(), EngineError> {
        let mut open = Vec::new();
        for &k in nodes {
            let task = self.task(state, level, k, trusted);
            match self.kept.read::<Outcome>(&task) {
                Some(outcome) => {
                    self.note(state, level, k, task, trusted, outcome);
                    step(1);
                }
                None => open.push((k, trusted)),
            }
        }
        for (k, outcome, chosen) in self.trained(state, level, &open, step)? {
            let task = self.task(state, level, k, trusted);
            self.note(state, level, k, task, trusted, outcome);
            chosen.and_then(|chosen| state.models[level].insert(k, chosen));
        }
        Ok(())
    }

    fn note(
        &self,
        state: &mut State,
        level: usize,
        k: usize,
        task: String,
        trusted: Trusted,
        outcome: Outcome,
    ) {
        let before = match level {
            0 => Some(0.0),
            _ => state.visited[level - 1].get(&self.tree.levels[level][k].parent).and_then(|v| v.total),
        };
        let total = before.zip(outcome.evidence).map(|(before, e)| before + e.ln_marginal);
        state.visited[level].insert(k, Visited { task, trusted, outcome, total });
        // That of another way to train.
        state.models[level].remove(&k);
    }

    fn task(&self, state: &State, level: usize, k: usize, trusted: Trusted) -> String {
        let node = &self.tree.levels[level][k];
        let parent = level.checked_sub(1).and_then(|before| state.visited[before].get(&node.parent));
        self.names.task(level, &node.choice, parent.map_or("", |p| &p.task), trusted)
    }

    /// Trains nodes of a level at once, and keeps what they found.
    fn trained(
        &self,
        state: &mut State,
        level: usize,
        nodes: &[(usize, Trusted)],
        step: Steps<'_>,
    ) -> Result<Vec<(usize, Outcome, Option<Chosen>)>, EngineError> {
        // Of tasks that were kept from before there is no model: those on which one stands that is to be
        // trained are trained again.
        for before in 0..level {
            let wanted: BTreeSet<usize> =
                nodes.iter().map(|(k, _)| self.tree.path(level, *k)[before]).collect();
            let missing = wanted.into_iter().filter(|k| !state.models[before].contains_key(k));
            let again: Vec<_> =
                missing.filter_map(|k| Some((k, state.visited[before].get(&k)?.trusted))).collect();
            for (k, _, chosen) in self.trained(state, before, &again, &|_| step(0))? {
                chosen.and_then(|chosen| state.models[before].insert(k, chosen));
            }
        }
        let state = &*state;
        let one = |&(k, trusted): &(usize, Trusted)| {
            if !step(0) {
                return Err(EngineError::Stopped);
            }
            let (outcome, chosen) = self.train(state, level, k, trusted)?;
            self.kept.write(&self.task(state, level, k, trusted), &outcome)?;
            step(1);
            // Nothing stands on the last stage.
            Ok((k, outcome, chosen.filter(|_| level + 1 < self.tree.levels.len())))
        };
        nodes.par_iter().map(one).collect()
    }

    fn train(
        &self,
        state: &State,
        level: usize,
        k: usize,
        trusted: Trusted,
    ) -> Result<(Outcome, Option<Chosen>), EngineError> {
        let mut done = Vec::with_capacity(level);
        for (before, k) in self.tree.path(level, k).into_iter().enumerate().take(level) {
            let stage = || self.run.study.plan.stages[before].id.clone();
            let chosen = state.models[before].get(&k).cloned();
            let chosen = chosen.ok_or_else(|| EngineError::Damaged { stage: stage() })?;
            let choice = Choice::clone(&self.tree.levels[before][k].choice);
            done.push(Done::of(choice, chosen));
        }
        let run = self.run.standing_on(done);
        let stage = &run.study.plan.stages[level];
        let row = Row { own: Vec::new(), choice: Choice::clone(&self.tree.levels[level][k].choice) };
        let points = selected(&run.study, &run.observed, &stage.points);
        let stands_on = Earlier::new(&run).of(stage, &row.choice, &points)?;
        let without = |remark: String| Ok((Outcome { evidence: None, remark: Some(remark) }, None));
        let found = match run.train_row(stage, &row, stands_on, trusted) {
            Ok(found) => found,
            Err(error) => return without(error.to_string()),
        };
        let (evidence, warnings) = (EvidenceRecord::of(&found.trained), &found.trained.warnings);
        if !evidence.ln_marginal.is_finite() {
            return without("its evidence is no finite number".to_owned());
        }
        let remark = Some(warnings.join("\n")).filter(|w| !w.is_empty());
        Ok((Outcome { evidence: Some(evidence), remark }, Some(found)))
    }

    /// The nodes of the combination that ranks stage by stage.
    pub(super) fn greedy(&self, step: Steps<'_>) -> Result<Vec<usize>, EngineError> {
        let task = self.names.greedy();
        if let Some(path) = self.kept.read::<Vec<Choice>>(&task).and_then(|kept| self.tree.find(&kept)) {
            return Ok(path);
        }
        let mut run = self.run.standing_on(Vec::new());
        while run.next_stage()?.is_some() {
            if !step(0) {
                return Err(EngineError::Stopped);
            }
        }
        let mut path: Vec<Arc<Choice>> = Vec::new();
        for (done, stage) in run.done.iter().zip(&run.study.plan.stages) {
            settle(&run.study, stage, &done.choice, &mut path);
            path.push(Arc::new(done.choice.clone()));
        }
        let choices: Vec<Choice> = path.iter().map(|c| Choice::clone(c)).collect();
        self.kept.write(&task, &choices)?;
        let unknown = || EngineError::Damaged { stage: run.study.plan.stages[0].id.clone() };
        self.tree.find(&choices).ok_or_else(unknown)
    }
}
