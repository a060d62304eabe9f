//! What to measure next: what further measurements would tell of parameters, of which model is right, and of
//! a quantity.
//!
//! Knows trained models to first order. It trains none, and reads no record.

mod microphones;
mod place;
mod plan;
mod plot;
mod predictive;
mod pressures;
mod sequence;
mod told;
mod visit;

pub use microphones::{MicrophoneChoice, MicrophoneTable, microphones};
pub use place::Wish;
pub use sequence::{Lead, Leads, Sequence};
pub use told::Aim;

use super::stages::average::OpenModel;
use crate::run::points::ready::Known;
use crate::{EngineError, SavedModel};
use place::Place;
use plan::Worth;
use predictive::Numbers;
use rayon::prelude::*;
use rijke_numerics::InOrder;
use rijke_study::{ObservedModes, Study};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use told::Told;

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
    /// Expected logarithm of the Bayes factor, nats: if the model is right, for it; if the rival is right,
    /// for that.
    pub models: Option<[f64; 2]>,
    /// Expected information about which of several open models is right, nats, at least.
    pub which: Option<f64>,
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
    /// Candidates of the model that went on, and of the others, the most probable first.
    pub models: Vec<BTreeMap<String, String>>,
    /// All that can be told of which of several open models is right, nats.
    pub entropy: Option<f64>,
    /// All possible points, the most nats per hour first.
    pub points: Vec<Suggestion>,
    /// The plan in the order in which each visit adds most.
    pub plan: Vec<Step>,
    /// What the plan would tell, and what the greedy one would, nats.
    pub total: [f64; 2],
    /// The logarithm of the Bayes factor by the whole plan, nats, for the model if it is right, and for its
    /// rival if that is: mean and standard deviation.
    pub factor: Option<[[f64; 2]; 2]>,
    /// Standard deviation of the growth rate asked for, 1/s: now, and after the plan.
    pub quantity_sd: Option<[f64; 2]>,
    /// The best further point after the plan, and what it would add, nats.
    pub further: Option<(String, f64)>,
    /// Points that cannot be judged, and why.
    pub left_out: Vec<(String, String)>,
}

/// What to measure next, by the `model` that went on from its stage and its `rivals`, the most probable
/// first, to first order at the most probable parameters. The first rival is what the model is compared with;
/// of two or more, which of all is right can be the aim.
///
/// Each point is a new visit, which measures what trained: of every mode that was measured there (at a new
/// point, that trained) growth rate and frequency, and relative pressures if the stage hears any. Its noise
/// is the misfit of the model, which comes again if the point was measured, and the root mean square of the
/// measured errors of the points that trained. Points of one name of installation share what installations
/// differ by; none shares it with the points that trained.
///
/// # Errors
/// [`EngineError::NothingToMeasure`], [`EngineError::Damaged`], and those of the files.
pub fn next(
    study: &Study,
    observations: &ObservedModes,
    model: &SavedModel,
    rivals: &[OpenModel],
    wish: &Wish,
) -> Result<Next, EngineError> {
    measured_once(model)?;
    let place = Place::new(Known::of(study, observations)?, study.channels()?);
    let mut microphones = if wish.without_pressures { BTreeSet::new() } else { place.heard(model) };
    if !microphones.is_empty() {
        microphones.insert(study.rig.microphones.reference);
    }
    let able = place.measurable(model, rivals, wish, &microphones.into_iter().collect::<Vec<_>>())?;
    let judged = Judged { study, kept: &able.kept, told: able.told(&Numbers::clone) };
    let mut found = judged.plan(wish)?;
    found.stage.clone_from(&model.stage);
    let others = rivals.iter().map(|rival| &rival.model);
    found.models = std::iter::once(model).chain(others).map(|m| m.candidates.clone()).collect();
    for (suggestion, &k) in found.points.iter_mut().zip(&able.kept) {
        suggestion.repeat = model.trained_on.contains(&study.campaign.points[k].id);
    }
    let rate = |s: &Suggestion| s.nats / s.hours.unwrap_or(1.0);
    found.points.sort_by(|a, b| rate(b).total_cmp(&rate(a)));
    found.left_out = able.left_out;
    Ok(found)
}

/// Refuses a model that no mode trained: nothing says by how much a measurement of its modes will scatter.
fn measured_once(model: &SavedModel) -> Result<(), EngineError> {
    if !model.trained_on.is_empty() {
        return Ok(());
    }
    let reason = "no mode was measured at its points, so the scatter of measurements about the model is not known; measure one point first";
    Err(EngineError::NothingToMeasure { stage: model.stage.clone(), reason: reason.into() })
}

/// Points that can be judged.
struct Judged<'a> {
    study: &'a Study,
    kept: &'a [usize],
    told: Told,
}

impl Judged<'_> {
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
                parameters: self.told.mine.information(&[k])?,
                models: self.told.models(&[k])?,
                which: self.told.which(&[k])?,
                quantity: self.told.about(&[k])?,
                nats: self.told.gain(wish.aim, &[k])?,
            })
        };
        let points = (0..self.kept.len()).into_par_iter().map(alone).in_order::<Result<Vec<_>, _>>()?;
        let gain = |set: &[usize]| self.told.gain(wish.aim, set);
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
        let quantity_sd = self.told.quantity.map(|q| self.told.mine.variances(q, &best)).transpose()?;
        Ok(Next {
            stage: String::new(),
            aim: wish.aim,
            models: Vec::new(),
            entropy: (self.told.rivals.len() > 1).then(|| self.told.entropy()),
            points,
            plan: (0..best.len()).map(step).collect::<Result<_, _>>()?,
            total: [total, told(&greedy)?],
            factor: if best.is_empty() { None } else { self.told.factor(&best)? },
            quantity_sd: quantity_sd.map(|v| v.map(f64::sqrt)),
            further,
            left_out: Vec::new(),
        })
    }
}
