//! Stages that stand on each other.

use super::super::course::{Beside, Done, Run, Trusted};
use super::super::points::inputs::selected;
use super::super::record::{
    CarriedOn, MeasuredRecord, ModelRecord, StageRecord, add_lines, not_carried, with_later,
};
use super::super::suspects::far::FarOff;
use super::ahead::{not_tried, open_beside};
use super::compete::{best_of, goes_on};
use crate::rows::{Choice, Row};
use crate::{EngineError, NamedGaussian};
use rijke_inference::Conflict;
use rijke_numerics::words::with_sd;
use rijke_study::plan::Stage;

impl Run {
    /// Runs the next stage; none after the last.
    ///
    /// # Errors
    /// [`EngineError::NoPoint`], [`EngineError::NoWinner`], [`EngineError::Stopped`], and models that cannot
    /// be assembled. One that cannot be fitted is a row without evidence.
    pub fn next_stage(&mut self) -> Result<Option<StageRecord>, EngineError> {
        let Some(stage) = self.study.plan.stages.get(self.done.len()).cloned() else { return Ok(None) };
        let (rows, mut results) = self.competed(&stage, &|_| true)?;
        let choices: Vec<&Choice> = rows.iter().map(|row| &row.choice).collect();
        let (carried, trained) = self.carried_on(&stage, &results, &choices);
        self.go_on()?;
        let [winner, next] = goes_on(&stage, &results, &carried)?;
        let (winner, chosen) = (results[winner].0.id.clone(), results[next].0.id.clone());
        let mut assumes = self.assumes(&stage, [&chosen, &winner]);
        let best = best_of(&results);
        self.average(&stage, &rows[next], &mut results[next].0, best);
        if let (model, Some(found)) = &mut results[next] {
            let said = self.relabelled(found, &model.predicted);
            add_lines(&mut model.remark, said);
        }
        let models: Vec<ModelRecord> = results.iter().map(|(model, _)| model.clone()).collect();
        let mut open = self.done.iter().flat_map(|done| &done.open).flat_map(|(_, c)| &c.later);
        assumes.extend(not_tried(&models).filter(|_| open.any(|later| later.stage == stage.id)));
        let own = undecided(&stage, &models, &chosen, &carried);
        let Row { choice, .. } = rows.into_iter().nth(next).unwrap_or_default();
        let grounds = self.study.plan.grounds(&stage).into_iter().filter_map(|id| self.ground(id));
        let known = results[next].1.as_ref().map_or(&[][..], |found| &found.known[..]);
        let undescribed =
            grounds.filter_map(|ground| ground.undescribed(&choice)).chain(held_far(&stage, known)).collect();
        if let Some(goes_on) = results[next].1.clone() {
            let rows = results.into_iter().filter_map(|(model, found)| Some((model, found?))).collect();
            let beside = goes_on.beside.as_ref().map(|said| format!("In stage \"{}\", {said}", stage.title));
            let lost = not_carried(&models, &carried, stage.decides);
            let lost = lost.map(|said| format!("Of the models of stage \"{}\", {said}", stage.title));
            let assumes = assumes.iter().cloned().chain(own).chain(lost).chain(beside).collect();
            let open = open_beside(&chosen, &carried);
            let odds = |b: &Beside| open.iter().find(|(_, c)| c.id == b.on).map(|(odds, _)| odds * b.odds);
            let beside = trained.into_iter().filter_map(|b| Some(Beside { odds: odds(&b)?, ..b })).collect();
            self.done.push(Done { choice, chosen: goes_on, rows, assumes, open, beside });
        }
        let (mut missing, mut checks, mut lengths, mut moved_since) = (None, None, None, None);
        if let Some(done) = self.done.last().filter(|done| !done.chosen.observed.is_empty()) {
            missing = self.missing(&stage, &done.chosen)?;
            moved_since = missing.as_ref().and_then(|missing| self.moved_since(&stage, missing));
            let rival = done.rival().map(|(model, found)| (model.id.as_str(), found));
            checks = Some(self.checks(&stage, &done.chosen, rival)?);
            lengths = if self.lengths { self.exact_lengths(&stage, &done.rows) } else { None };
        }
        let points = selected(&self.study, &self.observed, &stage.points);
        let measured: Vec<MeasuredRecord> = points.iter().map(MeasuredRecord::of).collect();
        let goes_on = models.iter().find(|m| m.id == chosen);
        let missed = goes_on.and_then(|model| Some(FarOff::of(&measured, model)?.words()));
        Ok(Some(StageRecord {
            id: stage.id,
            title: stage.title,
            measured,
            models,
            winner,
            chosen,
            decides: stage.decides,
            assumes,
            one_start: self.trusted == Trusted::Laplace,
            missed,
            undescribed,
            carried,
            missing,
            moved_since,
            lengths,
            checks,
        }))
    }

    /// What the stages on which `stage` stands took for certain, though their evidence does not decide it,
    /// and with which of the models that they leave open another model than these, that which goes on and the
    /// best, would be the best of `stage`.
    fn assumes(&self, stage: &Stage, these: [&str; 2]) -> Vec<String> {
        let mut all: Vec<String> = Vec::new();
        for said in stage.on.iter().filter_map(|id| self.stage_done(id)).flat_map(|done| &done.assumes) {
            if !all.contains(said) {
                all.push(said.clone());
            }
        }
        for ground in stage.on.iter().filter_map(|id| self.ground(id)) {
            // What it leaves open itself are rows here, or candidates that the stage names.
            all.extend(ground.assumes.iter().cloned());
        }
        for (done, before) in self.done.iter().zip(&self.study.plan.stages) {
            for (_, open) in &done.open {
                let other =
                    open.later.iter().find(|l| l.stage == stage.id && !these.contains(&l.model.as_str()));
                all.extend(other.map(|l| {
                    format!(
                        "If `{}` were right in stage \"{}\", `{}` would be the best model here",
                        open.id, before.title, l.model
                    )
                }));
            }
        }
        all
    }
}

/// What is taken for certain if the model called `taken` goes on: a sentence that names the other model of
/// most evidence, where its lead does not decide, and every further candidate with which some model is open.
fn undecided(stage: &Stage, models: &[ModelRecord], taken: &str, carried: &[CarriedOn]) -> Option<String> {
    let worth = |m: &ModelRecord| match carried.is_empty() {
        true => m.evidence.map(|e| e.ln_marginal),
        false => with_later(carried, &m.id),
    };
    let own = models.iter().find(|m| m.id == taken)?;
    let at = worth(own)?;
    let behind = |m: &ModelRecord| worth(m).map(|w| at - w).filter(|b| *b < stage.decides);
    let others = models.iter().filter(|m| m.id != taken).filter_map(|m| Some((m, behind(m)?)));
    let mut open: Vec<(&ModelRecord, f64)> = others.collect();
    open.sort_by(|a, b| a.1.total_cmp(&b.1));
    let place = |b: f64| format!("{:.1} nats {}", b.abs(), if b < 0.0 { "ahead" } else { "behind" });
    let (other, least) = open.first()?;
    let mut further: Vec<(&String, f64)> = Vec::new();
    for (model, behind) in &open {
        for (role, candidate) in &model.candidates {
            let named = [own, other].iter().any(|m| m.candidates.get(role) == Some(candidate));
            if !named && further.iter().all(|(known, _)| *known != candidate) {
                further.push((candidate, *behind));
            }
        }
    }
    let further: Vec<String> =
        further.iter().map(|(id, behind)| format!("{id} ({})", place(*behind))).collect();
    let also = if further.is_empty() {
        String::new()
    } else {
        format!("; nor is it decided against {}", further.join(", "))
    };
    let by = if carried.is_empty() { "" } else { " by the points of this and later stages" };
    Some(format!(
        "Stage \"{}\" takes {taken}, and {} is {}{}{by}{also}",
        stage.title,
        other.id,
        if *least < 0.0 { "" } else { "only " },
        place(*least)
    ))
}

/// Which parameters a stage holds so far from what the stages found on which it stands that the two
/// conflict, a sentence each without its stop.
fn held_far(stage: &Stage, known: &[NamedGaussian]) -> Vec<String> {
    let one = |(name, value): (&String, &f64)| {
        let of = |g: &NamedGaussian| {
            let i = g.names.iter().position(|n| n == name)?;
            Some((g.mean[i], g.covariance[(i, i)].sqrt()))
        };
        let (mean, sd) = known.iter().find_map(of)?;
        let far = (value - mean).abs() / sd;
        (far > Conflict::LIMIT).then(|| {
            format!(
                "this stage holds `{name}` at {value}, {far:.0} standard deviations from the {} that earlier stages found: its other parameters make \
                 up for the difference, and its evidence does not count it; leave `{name}` out of `hold`, or do not stand on these stages",
                with_sd(mean, sd)
            )
        })
    };
    stage.hold.iter().filter_map(one).collect()
}
