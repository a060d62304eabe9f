//! Candidates that compete on the same points; stages that stand on each other.

use super::course::{CONTENDS, Chosen, Done, Run, Trusted};
use super::earlier::Earlier;
use super::inputs::selected;
use super::record::{MeasuredRecord, ModelRecord, StageRecord, nearest};
use super::rows::Row;
use crate::EngineError;
use rayon::prelude::*;
use rijke_study::plan::{Prefer, Stage};

/// What is taken for certain if the model called `taken` goes on: a sentence that names the other model that is as good, if there is one, and every
/// other candidate of a role whose best model is.
fn undecided(title: &str, models: &[ModelRecord], taken: &str, decides: f64) -> Option<String> {
    let (other, behind) = nearest(models, taken).filter(|(_, behind)| *behind < decides)?;
    let lies = if behind < 0.0 { "ahead" } else { "behind" };
    let own = models.iter().find(|m| m.id == taken)?;
    let mut further: Vec<(&str, f64)> = Vec::new();
    for model in models.iter().filter(|m| m.id != taken) {
        let behind = own.ln_evidence() - model.ln_evidence();
        for (role, candidate) in model.candidates.iter().filter(|_| behind < decides) {
            if own.candidates.get(role) == Some(candidate) || other.candidates.get(role) == Some(candidate) {
                continue;
            }
            match further.iter_mut().find(|(known, _)| known == candidate) {
                Some((_, least)) => *least = least.min(behind),
                None => further.push((candidate, behind)),
            }
        }
    }
    let place =
        |behind: f64| format!("{:.1} {}", behind.abs(), if behind < 0.0 { "ahead" } else { "behind" });
    let further: Vec<String> =
        further.iter().map(|(id, behind)| format!("{id} ({})", place(*behind))).collect();
    let also = if further.is_empty() {
        String::new()
    } else {
        format!("; nor is it decided against {}", further.join(", "))
    };
    Some(format!(
        "{title}: {taken} is taken, though {} is only {:.1} nats {lies}{also}",
        other.id,
        behind.abs()
    ))
}

impl Run {
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
