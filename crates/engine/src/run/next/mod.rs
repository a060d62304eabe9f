//! What to measure next: what further measurements would tell of parameters, of which model is right, and of a quantity.

mod plan;
mod predictive;

use super::followed::Followed;
use super::inputs::{ambient_of_all, conditions, observed, states};
use super::rows::assembly_of;
use crate::noise::{measured_sd, of_point_and_installation, varying};
use crate::{Conditions, EngineError, Observed, SavedModel, TrainedPosterior};
use plan::Worth;
use predictive::{Numbers, Predictive, Shared};
use rayon::prelude::*;
use rijke_study::plan::Stage;
use rijke_study::{BaseState, Observations, Study};
use serde::Serialize;
use std::collections::BTreeMap;

/// What further measurements are for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Aim {
    /// To know the parameters of the model that went on.
    #[default]
    Parameters,
    /// To tell it from its rival.
    Models,
    /// To know its growth rate at a point that is not measured.
    Quantity,
}

/// What is wanted of [`next`].
#[derive(Clone, Debug, Default)]
pub struct Wish {
    /// What the plan is for.
    pub aim: Aim,
    /// Points that may be measured, by their places in the campaign. One that was measured is a repeat.
    pub candidates: Vec<usize>,
    /// The point whose growth rate is asked for.
    pub about: Option<usize>,
    /// How many points to plan.
    pub points: usize,
    /// Whether relative pressures are measured too.
    pub pressures: bool,
}

/// What one further measurement would tell.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Suggestion {
    /// Name of the point.
    pub point: String,
    /// Value of every factor, SI; none where it has none.
    pub factors: Vec<Option<f64>>,
    /// Whether the model was trained on this point.
    pub repeat: bool,
    /// What it costs alone, h; none where study.toml does not say.
    pub hours: Option<f64>,
    /// Expected information about the parameters, nats.
    pub parameters: f64,
    /// Expected logarithm of the Bayes factor, nats: if the model is right, for it; if the rival is right, for that.
    pub models: Option<[f64; 2]>,
    /// Expected information about the quantity, nats.
    pub quantity: Option<f64>,
    /// What counts for the aim, nats.
    pub nats: f64,
}

/// A visit of the plan.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Step {
    /// Name of the point.
    pub point: String,
    /// What it adds to the visits before it, nats.
    pub adds: f64,
    /// What it costs after them, h.
    pub hours: Option<f64>,
}

/// What to measure next.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Next {
    /// The stage whose models are meant.
    pub stage: String,
    /// What the plan is for.
    pub aim: Aim,
    /// Candidates of the model that went on, and of its rival.
    pub models: Vec<BTreeMap<String, String>>,
    /// All possible points, the most nats per hour first.
    pub points: Vec<Suggestion>,
    /// The plan in the order in which each visit adds most.
    pub plan: Vec<Step>,
    /// What the plan would tell, and what the greedy one would, nats.
    pub total: [f64; 2],
    /// Standard deviation of the growth rate asked for, 1/s: now, and after the plan.
    pub quantity_sd: Option<[f64; 2]>,
    /// The best further point after the plan, and what it would add, nats.
    pub further: Option<(String, f64)>,
    /// Points that cannot be judged, and why.
    pub left_out: Vec<(String, String)>,
}

/// What to measure next, by the `model` that went on from its stage and its `rival`, to first order at the most probable parameters.
///
/// Each point is a new visit: its noise is the misfit of the model and the root mean square of the measured errors of the points that
/// trained. Points of one name of installation share what installations differ by; none shares it with the points that trained.
///
/// # Errors
/// [`EngineError::NothingToMeasure`], [`EngineError::Damaged`], and those of the files.
pub fn next(
    study: &Study,
    observations: &Observations,
    model: &SavedModel,
    rival: Option<&SavedModel>,
    wish: &Wish,
) -> Result<Next, EngineError> {
    let nothing = |reason: String| EngineError::NothingToMeasure { stage: model.stage.clone(), reason };
    let Some((_, stage)) = study.plan.stage(&model.stage) else {
        return Err(nothing("the study has no such stage; rank it again".into()));
    };
    let place = Place::new(study, observations)?;
    let mine = place.expected(stage, model, wish)?;
    let theirs = match rival {
        Some(rival) => place.expected(stage, rival, wish)?,
        None => wish.candidates.iter().map(|_| Ok(Numbers::default())).collect(),
    };
    let about = wish.about.map(|k| place.wanted(model, k)).transpose()?;
    let (mut kept, mut left_out) = (Vec::new(), Vec::new());
    let mut numbers = [Vec::new(), Vec::new()];
    for ((&k, a), b) in wish.candidates.iter().zip(mine).zip(theirs) {
        match (a, b) {
            (Ok(a), Ok(_)) if a.values[0] > 0.0 => {
                let why = format!(
                    "the model says that the mode grows there, by {:.2} 1/s: it rings by itself, and has no decay to be measured",
                    a.values[0]
                );
                left_out.push((study.campaign.points[k].id.clone(), why));
            }
            (Ok(a), Ok(b)) => {
                kept.push(k);
                numbers[0].push(a);
                numbers[1].push(b);
            }
            (Err(e), _) | (_, Err(e)) => {
                left_out.push((study.campaign.points[k].id.clone(), e.to_string()));
            }
        }
    }
    if kept.is_empty() {
        let reason = left_out.into_iter().next().map(|(_, reason)| reason);
        return Err(nothing(reason.unwrap_or_else(|| "no point is given".into())));
    }
    let [mut own, others] = numbers;
    // The quantity stands behind all points.
    let quantity = about.is_some().then_some(kept.len());
    own.extend(about);
    let mine = Predictive::new(own, &model.posterior()?.knowledge.covariance);
    let rival = rival
        .map(|r| Ok::<_, EngineError>((r, Predictive::new(others, &r.posterior()?.knowledge.covariance))))
        .transpose()?;
    let judged = Judged { study, kept: &kept, mine, rival: rival.as_ref().map(|(_, p)| p), quantity };
    match (wish.aim, judged.rival, quantity) {
        (Aim::Models, None, _) => {
            return Err(nothing("only one model of it could be fitted: there is nothing to decide".into()));
        }
        (Aim::Quantity, _, None) => {
            return Err(nothing("no point is given whose growth rate is wanted".into()));
        }
        _ => {}
    }
    let mut found = judged.plan(wish)?;
    found.stage.clone_from(&model.stage);
    found.models =
        std::iter::once(model).chain(rival.iter().map(|(r, _)| *r)).map(|m| m.candidates.clone()).collect();
    found.left_out = left_out;
    for (suggestion, &k) in found.points.iter_mut().zip(&kept) {
        suggestion.repeat = model.trained_on.contains(&study.campaign.points[k].id);
    }
    let rate = |s: &Suggestion| s.nats / s.hours.unwrap_or(1.0);
    found.points.sort_by(|a, b| rate(b).total_cmp(&rate(a)));
    Ok(found)
}

/// Points that can be judged.
struct Judged<'a> {
    study: &'a Study,
    kept: &'a [usize],
    mine: Predictive,
    rival: Option<&'a Predictive>,
    quantity: Option<usize>,
}

impl Judged<'_> {
    fn models(&self, set: &[usize]) -> Result<Option<[f64; 2]>, EngineError> {
        let Some(rival) = self.rival else { return Ok(None) };
        Ok(Some([self.mine.divergence(rival, set)?, rival.divergence(&self.mine, set)?]))
    }

    fn about(&self, set: &[usize]) -> Result<Option<f64>, EngineError> {
        let Some(quantity) = self.quantity else { return Ok(None) };
        let [before, after] = self.mine.variances(quantity, set)?;
        Ok(Some(0.5 * (before / after).ln()))
    }

    fn gain(&self, aim: Aim, set: &[usize]) -> Result<f64, EngineError> {
        Ok(match aim {
            Aim::Parameters => self.mine.information(set)?,
            // Whichever of the two is right, so much is expected at least.
            Aim::Models => self.models(set)?.map_or(0.0, |[a, b]| a.min(b)),
            Aim::Quantity => self.about(set)?.unwrap_or(0.0),
        })
    }

    /// Hours of the visits, each installation mounted once.
    fn hours(&self, set: &[usize]) -> Option<f64> {
        let cost = self.study.plan.cost?;
        let mut mounted: Vec<&str> =
            set.iter().map(|&k| self.study.campaign.points[self.kept[k]].installation.as_str()).collect();
        mounted.sort_unstable();
        mounted.dedup();
        Some((set.len() as f64 * cost.point + mounted.len() as f64 * cost.installation) / 3600.0)
    }

    fn name(&self, k: usize) -> String {
        self.study.campaign.points[self.kept[k]].id.clone()
    }

    /// Every point alone, in the order of the candidates, and the plan.
    fn plan(&self, wish: &Wish) -> Result<Next, EngineError> {
        let alone = |k: usize| -> Result<Suggestion, EngineError> {
            let factors = &self.study.campaign.points[self.kept[k]].factors;
            Ok(Suggestion {
                point: self.name(k),
                factors: factors.iter().map(|v| Some(*v).filter(|v| v.is_finite())).collect(),
                repeat: false,
                hours: self.hours(&[k]),
                parameters: self.mine.information(&[k])?,
                models: self.models(&[k])?,
                quantity: self.about(&[k])?,
                nats: self.gain(wish.aim, &[k])?,
            })
        };
        let points = (0..self.kept.len()).map(alone).collect::<Result<Vec<_>, _>>()?;
        let gain = |set: &[usize]| self.gain(wish.aim, set);
        let worth = Worth { gain: &gain, cost: &|set| self.hours(set).unwrap_or(set.len() as f64) };
        let all: Vec<usize> = (0..self.kept.len()).collect();
        let greedy = worth.greedy(&all, wish.points)?;
        let best = worth.ordered(&worth.exchanged(&all, greedy.clone())?)?;
        let told = |set: &[usize]| if set.is_empty() { Ok(0.0) } else { gain(set) };
        let step = |n: usize| -> Result<Step, EngineError> {
            let (before, after) = (&best[..n], &best[..=n]);
            let hours = self.hours(after).map(|h| h - self.hours(before).unwrap_or(0.0));
            Ok(Step { point: self.name(best[n]), adds: told(after)? - told(before)?, hours })
        };
        let total = told(&best)?;
        let further = match worth.next(&all, &best)? {
            Some(k) => Some((self.name(k), told(&[&best[..], &[k]].concat())? - total)),
            None => None,
        };
        let quantity_sd = self.quantity.map(|q| self.mine.variances(q, &best)).transpose()?;
        Ok(Next {
            stage: String::new(),
            aim: wish.aim,
            models: Vec::new(),
            points,
            plan: (0..best.len()).map(step).collect::<Result<_, _>>()?,
            total: [total, told(&greedy)?],
            quantity_sd: quantity_sd.map(|v| v.map(f64::sqrt)),
            further,
            left_out: Vec::new(),
        })
    }
}

/// What is known of the points of a study, whichever model is asked.
struct Place<'a> {
    study: &'a Study,
    observed: Vec<Observed>,
    states: BTreeMap<usize, BaseState>,
    ambient: Vec<Option<[f64; 2]>>,
}

impl<'a> Place<'a> {
    fn new(study: &'a Study, observations: &Observations) -> Result<Self, EngineError> {
        let ambient = ambient_of_all(study, observations);
        let states = states(study, &ambient, true)?;
        let observed = observed(study, observations, &states, &ambient)?;
        Ok(Self { study, observed, states, ambient })
    }

    /// The conditions at a point of the campaign, where they can be known: a model that was trained with inferred states needs one.
    fn conditions(&self, model: &SavedModel, k: usize) -> Result<Conditions, EngineError> {
        let point = &self.study.campaign.points[k];
        let trained = || model.trained_on.iter().filter_map(|id| self.study.campaign.point(id));
        let ambient = self.ambient[k].or_else(|| trained().find_map(|(t, _)| self.ambient[t]));
        conditions(self.study, point, self.states.get(&k), ambient)
    }

    /// A point by a model, where its mode is sought as it was when it was measured.
    fn numbers(
        &self,
        model: &SavedModel,
        posterior: &TrainedPosterior,
        k: usize,
        microphones: &[usize],
    ) -> Result<Numbers, EngineError> {
        let conditions = self.conditions(model, k)?;
        let assembly = assembly_of(self.study, &model.candidates, &model.hold)?;
        let seen = self.observed.iter().find(|o| o.conditions.id == conditions.id);
        let followed = Followed::of(self.study, &self.observed, &model.trained_on);
        let first = followed.labels().first();
        let near = seen.map(|o| o.near).or_else(|| followed.near(first?, &conditions));
        let (known, law) = (&posterior.knowledge, model.law.as_ref());
        let linear = posterior.linear(known, &assembly, &conditions, microphones, near, law)?;
        // Repeated visits of a point share the errors of its gas: some of them are made anew, but this promises less.
        let shared = linear.base.into_iter().chain(linear.law).map(|(c, change)| (Shared::Cause(c), change));
        let mut numbers = Numbers {
            noise: vec![0.0; linear.values.len()],
            values: linear.values,
            along: linear.along,
            shared: shared.collect(),
        };
        for (name, sd) in varying(&posterior.noise) {
            let place = known.names.iter().position(|n| n == name);
            if let Some((_, slope)) = numbers.along.iter().find(|(at, _)| Some(*at) == place) {
                let cause = Shared::Varying(name.to_owned(), conditions.point.installation.clone());
                numbers.shared.insert(cause, slope.iter().map(|d| d * sd).collect());
            }
        }
        Ok(numbers)
    }

    /// What measuring each point would give.
    fn expected(
        &self,
        stage: &Stage,
        model: &SavedModel,
        wish: &Wish,
    ) -> Result<Vec<Result<Numbers, EngineError>>, EngineError> {
        let posterior = model.posterior()?;
        let rig = &self.study.rig;
        let all = if wish.pressures { rig.microphones.at.len() } else { 0 };
        let microphones: Vec<usize> = (0..all).collect();
        let trained: Vec<Observed> =
            self.observed.iter().filter(|o| model.trained_on.contains(&o.conditions.id)).cloned().collect();
        let measured = stage.noise_of_predictions.as_ref().unwrap_or(&stage.noise).measured;
        let errors = [0, 1, 2].map(|k| if measured { measured_sd(&trained, k) } else { 0.0 });
        let noise = of_point_and_installation(&posterior.noise);
        let one = |&k: &usize| {
            let mut numbers = self.numbers(model, &posterior, k, &microphones)?;
            let rows = numbers.values.len();
            numbers.noise =
                (0..rows).map(|r| noise[r.min(2)][0].powi(2) + errors[r.min(2)].powi(2)).collect();
            for (r, [_, sd]) in noise.iter().enumerate().take(2).filter(|(_, [_, sd])| *sd > 0.0) {
                let cause = Shared::Installation(r, self.study.campaign.points[k].installation.clone());
                numbers.shared.insert(cause, (0..rows).map(|i| if i == r { *sd } else { 0.0 }).collect());
            }
            Ok(numbers)
        };
        Ok(wish.candidates.par_iter().map(one).collect())
    }

    /// The growth rate at a point in an installation of its own, without noise.
    fn wanted(&self, model: &SavedModel, k: usize) -> Result<Numbers, EngineError> {
        let numbers = self.numbers(model, &model.posterior()?, k, &[])?;
        let apart = |cause: Shared| match cause {
            Shared::Varying(name, _) => Shared::Varying(name, String::new()),
            other => other,
        };
        Ok(Numbers {
            values: numbers.values[..1].to_vec(),
            along: numbers.along.into_iter().map(|(at, slope)| (at, slope[..1].to_vec())).collect(),
            shared: numbers.shared.into_iter().map(|(c, s)| (apart(c), s[..1].to_vec())).collect(),
            noise: vec![0.0],
        })
    }
}
