//! Models that a stage leaves open, carried on through the stages that stand on it.
//!
//! By the chain rule of probability the evidence of all data together is the sum of the ln evidences of the
//! stages, each given what the earlier ones found. A cold stage may leave two inlets open between which the
//! hot points decide; the one that is taken too early then moves what later stages infer by many of their
//! standard deviations.

use super::super::course::{Beside, Chosen, Done, Found, Near, Run, Trusted};
use super::super::record::{CarriedOn, CarriedStage, ModelRecord, with_later};
use super::compete::{best_of, goes_on};
use crate::EngineError;
use crate::rows::{Choice, Row};
use rayon::prelude::*;
use rijke_study::Cause;
use rijke_study::plan::{NoiseSpec, Plan, Stage};
use std::collections::BTreeSet;

/// The most models of a stage that are carried on.
const MOST: usize = 8;
/// A model of a later stage that trails by more nats on the first model here is not tried on the others.
const REACH: f64 = 25.0;
/// Of more models of a later stage than this, only the best on the first model here are tried on the others.
const WIDEST: usize = 32;

impl Run {
    /// Carries on every model within `decides` nats of the best of its stage, of many the best [`MOST`]. No
    /// model is carried on where the stage decides or nothing stands on it. The evidence of later stages is,
    /// for the first of them, what these stages find; for the others Laplace's, at the maxima near to those.
    pub(in crate::run) fn carried_on(
        &self,
        stage: &Stage,
        results: &[Found],
        choices: &[&Choice],
    ) -> (Vec<CarriedOn>, Vec<Beside>) {
        let later = standing_on(&self.study.plan, &stage.id);
        let total = |k: usize| results[k].0.ln_evidence();
        let best = best_of(results);
        let fitted = |k: &usize| results[*k].1.is_some() && total(*k) >= best - stage.decides;
        let mut open: Vec<usize> = (0..results.len()).filter(fitted).collect();
        if later.is_empty() || open.len() < 2 {
            return (Vec::new(), Vec::new());
        }
        open.sort_by(|a, b| total(*b).total_cmp(&total(*a)));
        open.truncate(MOST);
        // The model that this stage alone would choose comes first: unless later stages overrule it, the
        // study needs its later rows anyway.
        if let Ok([_, next]) = goes_on(stage, results, &[])
            && let Some(place) = open.iter().position(|k| *k == next)
        {
            open[..=place].rotate_right(1);
        }
        let with = |k: usize, near: Option<&Near>| {
            let (model, chosen) = &results[k];
            let id = model.id.clone();
            match chosen.as_ref().map(|chosen| self.later(&later, &id, choices[k], chosen, near)) {
                Some(Ok(found)) => {
                    let ln_evidence = Some(model.ln_evidence() + found.ln_evidence);
                    (CarriedOn { id, ln_evidence, later: found.best }, Some(found.near), found.open)
                }
                _ => (CarriedOn { id, ln_evidence: None, later: Vec::new() }, None, Vec::new()),
            }
        };
        let (first, near, beside) = with(open[0], None);
        let others = open[1..].par_iter().map(|&k| with(k, near.as_ref())).collect::<Vec<_>>();
        let (mut all, mut trained) = (vec![first], beside);
        for (carried, _, beside) in others {
            all.push(carried);
            trained.extend(beside);
        }
        let place = |c: &CarriedOn| results.iter().position(|(m, _)| m.id == c.id);
        all.sort_by_key(place);
        (all, trained)
    }

    /// What the stages called `later` find if this model, called `id`, is right. `near` is what they found
    /// after another model: with it, only those models are tried, and their searches begin there.
    fn later(
        &self,
        later: &[String],
        id: &str,
        choice: &Choice,
        chosen: &Chosen,
        near: Option<&Near>,
    ) -> Result<Later, EngineError> {
        let taken = Done::of(choice.clone(), chosen.clone());
        let mut run = self.standing_on(self.done.iter().cloned().chain([taken]).collect());
        run.near = near.cloned().unwrap_or_default();
        // The rows of the first are those of the study, unless later stages overrule it.
        run.trusted = if near.is_none() { self.trusted } else { Trusted::Laplace };
        let mut found = Later { ln_evidence: 0.0, best: Vec::new(), near: Near::new(), open: Vec::new() };

        while let Some(stage) = run.study.plan.stages.get(run.done.len()).cloned() {
            let counts = later.contains(&stage.id);
            // A row of another candidate in one of its roles would stand on another model than this one.
            let agrees = |row: &Row| row.own.iter().all(|c| choice.get(&c.role).is_none_or(|id| *id == c.id));
            let tried = |row: &Row| near.is_none_or(|n| n.contains_key(&[stage.id.clone(), row.id()]));
            let (rows, results) = run.competed(&stage, &|row| !counts || (agrees(row) && tried(row)))?;
            let [winner, next] = goes_on(&stage, &results, &[])?;
            let best = results[winner].0.ln_evidence();
            if counts {
                let ModelRecord { id: model, parameters, .. } = results[winner].0.clone();
                found.ln_evidence += best;
                let mut reach: Vec<&ModelRecord> = within_reach(results.iter().map(|(m, _)| m)).collect();
                reach.sort_by(|a, b| b.ln_evidence().total_cmp(&a.ln_evidence()));
                let started = |m: &&ModelRecord| ([stage.id.clone(), m.id.clone()], m.parameters.clone());
                found.near.extend(reach.iter().take(WIDEST).map(started));
                found.best.push(CarriedStage { stage: stage.id.clone(), model, parameters });
                for (row, (m, trained)) in rows.iter().zip(&results) {
                    let odds = (m.ln_evidence() - best).exp();
                    if let Some(chosen) = trained.clone().filter(|_| odds >= (-stage.decides).exp()) {
                        let (on, stage, choice) = (id.to_owned(), stage.id.clone(), row.choice.clone());
                        let parameters = m.parameters.clone();
                        found.open.push(Beside { on, stage, odds, choice, parameters, chosen });
                    }
                }
            }
            if found.best.len() == later.len() {
                break;
            }
            if let Some(chosen) = results[next].1.clone() {
                run.done.push(Done::of(rows[next].choice.clone(), chosen));
            }
        }
        Ok(found)
    }
}

/// What later stages find if a model is right.
struct Later {
    /// Sum of the ln evidences of their best models.
    ln_evidence: f64,
    /// These models.
    best: Vec<CarriedStage>,
    /// All that come within [`REACH`] of them.
    near: Near,
    /// Those that their stages leave open, these among them; odds against the best of the same stage.
    open: Vec<Beside>,
}

impl Run {
    /// The installations of a stage of which stages that stand on it have points too, and count what
    /// installations differ by.
    pub(in crate::run) fn assemblies(&self, stage: &Stage) -> Vec<String> {
        let (plan, campaign) = (&self.study.plan, &self.study.campaign);
        let later = standing_on(plan, &stage.id);
        let counts = |s: &&Stage| {
            let noises = [Some(&s.noise), s.noise_of_predictions.as_ref()];
            let differs = |n: &NoiseSpec| n.installation.is_some() || !n.varying.is_empty();
            later.contains(&s.id) && s.base_errors && noises.into_iter().flatten().any(differs)
        };
        let points = |s: &Stage| {
            let of = campaign.points.iter().filter(|p| s.points.holds(campaign, p));
            of.map(|p| p.installation.clone()).collect::<BTreeSet<String>>()
        };
        if !stage.base_errors {
            return Vec::new();
        }
        let theirs: BTreeSet<String> = plan.stages.iter().filter(counts).flat_map(points).collect();
        points(stage).intersection(&theirs).cloned().collect()
    }

    /// The causes of error of the points of stages that stand on a stage.
    pub(in crate::run) fn causes(&self, stage: &Stage) -> Vec<Cause> {
        let (plan, campaign) = (&self.study.plan, &self.study.campaign);
        let later = standing_on(plan, &stage.id);
        let mut causes: BTreeSet<&Cause> = BTreeSet::new();
        for stage in plan.stages.iter().filter(|s| later.contains(&s.id)) {
            for observed in self.observed.iter().filter(|o| stage.points.holds(campaign, &o.conditions.point))
            {
                let conditions = &observed.conditions;
                causes.extend((observed.mode.drift_sd > 0.0).then_some(&Cause::Drift));
                causes.extend(conditions.displaced.iter().map(|d| &d.cause));
                if stage.base_errors {
                    causes.extend(conditions.base.errors.iter().map(|error| &error.cause));
                }
            }
        }
        causes.into_iter().cloned().collect()
    }
}

/// The models of a later stage that come within [`REACH`] of its best.
fn within_reach<'a>(
    models: impl Iterator<Item = &'a ModelRecord> + Clone,
) -> impl Iterator<Item = &'a ModelRecord> {
    let best = models.clone().map(ModelRecord::ln_evidence).fold(f64::NEG_INFINITY, f64::max);
    models.filter(move |m| m.ln_evidence() >= best - REACH)
}

/// What is said of models of a stage that were not tried on all that earlier stages leave open.
pub(super) fn not_tried(models: &[ModelRecord]) -> Option<String> {
    let near = within_reach(models.iter()).count();
    (near > WIDEST).then(|| {
        format!(
            "{near} models here lie within {REACH} nats of the best, and only the best {WIDEST} were tried on the other models that earlier stages leave \
             open: averages leave the rest out, and `rijke search` weighs all"
        )
    })
}

/// Of the models that were carried on, those beside the one called `chosen`, each with its odds against that
/// one.
pub(in crate::run) fn open_beside(chosen: &str, carried: &[CarriedOn]) -> Vec<(f64, CarriedOn)> {
    let Some(own) = with_later(carried, chosen) else { return Vec::new() };
    let odds = |c: &CarriedOn| Some(((c.ln_evidence? - own).exp(), c.clone()));
    carried.iter().filter(|c| c.id != chosen).filter_map(odds).collect()
}

/// The stages that stand on the one called `id`, or on one that does.
fn standing_on(plan: &Plan, id: &str) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for stage in &plan.stages {
        if stage.on.iter().any(|on| on == id || all.contains(on)) {
            all.push(stage.id.clone());
        }
    }
    all
}
