//! Lengths and diameters that a rig states as plain numbers, taken as exact: by how much one would have to be
//! wrong for the lead of a stage to turn, or for a parameter of the leader to move by its standard deviation.
//!
//! A length that is wrong by d moves the predictions of a model by g d, with g by differences of the model
//! itself; to first order that is data that read -g d more. Parameters follow and errors of the data count as
//! at the fit, and noise that floats is chosen again ([`rijke_inference::Linearised::moved_with_noise`]):
//! that is what ln evidence changes by, and the lead over the next model by the difference of the two.
//! Earlier stages would have found other values with the length: by how much their parameters, channels and
//! shared errors move, and with them the means from which this stage starts, goes through g. Places of
//! microphones are asked about in stages that stand alone: they may make an earlier stage choose another
//! model (docs/records/designs.md).

use super::course::{Chosen, Run};
use super::found::{ExactLengths, LengthError, MovingLength};
use super::points::inputs::conditions_or_ambient;
use super::record::ModelRecord;
use crate::predictor::Predictor;
use crate::{Assembly, EngineError, Observed};
use rayon::prelude::*;
use rijke_inference::{Forward, InferenceError, Parameter};
use rijke_numerics::Order;
use rijke_study::plan::Stage;
use rijke_study::{Rig, Shape, Study, Value};
use std::f64::consts::PI;
use std::sync::Arc;

/// Step of the differences, m.
const STEP: f64 = 1e-4;

/// Errors above this part of the rig's length are not asked about.
const LARGEST: f64 = 0.05;

/// How many lengths are told.
const TOLD: usize = 3;

impl Run {
    /// What errors of lengths would reverse the lead of the best of these models over the next; none where
    /// fewer than two could be fitted, or one cannot be shifted.
    pub(super) fn exact_lengths(
        &self,
        stage: &Stage,
        rows: &[(ModelRecord, Chosen)],
    ) -> Option<ExactLengths> {
        let mut best: Vec<&(ModelRecord, Chosen)> = rows.iter().collect();
        best.sort_by(|a, b| b.0.ln_evidence().total_cmp(&a.0.ln_evidence()));
        let two = best.get(..2)?;
        self.of_two(stage, [two[0], two[1]])
    }

    fn of_two(&self, stage: &Stage, two: [&(ModelRecord, Chosen); 2]) -> Option<ExactLengths> {
        let lead = two[0].0.ln_evidence() - two[1].0.ln_evidence();
        // What it stands on, first things first, then the two.
        let mut chain: Vec<(&Stage, &Chosen)> = Vec::new();
        let mut wanted: Vec<&str> = stage.on.iter().map(String::as_str).collect();
        for (before, done) in self.study.plan.stages.iter().zip(&self.done).rev() {
            if before.id != stage.id && wanted.contains(&before.id.as_str()) {
                chain.insert(0, (before, &done.chosen));
                wanted.extend(before.on.iter().map(String::as_str));
            }
        }
        chain.extend(two.map(|(_, chosen)| (stage, chosen)));
        let stated =
            |(stage, chosen): &(&Stage, &Chosen)| self.predicted(&self.study, stage, chosen, &[], 0.0);
        let stated: Vec<Vec<f64>> = chain.iter().map(stated).collect::<Result<_, _>>().ok()?;
        // By how much the data of the two read more per metre.
        let change = |study: &Study, step: f64| -> Result<Vec<Vec<f64>>, EngineError> {
            let (mut drift, mut found): (Vec<(&str, f64)>, _) = (Vec::new(), Vec::new());
            for (k, ((stage, chosen), here)) in chain.iter().zip(&stated).enumerate() {
                let there = self.predicted(study, stage, chosen, &drift, step)?;
                let trained = &chosen.trained;
                // The model's parameters moved with the prediction; shared errors and channels move here.
                let shared = |j: usize| {
                    let known = drift.iter().find(|(name, _)| *name == trained.parameters[j].name);
                    known.filter(|_| j >= trained.own).map_or(0.0, |(_, by)| by / trained.slope(j))
                };
                let shared: Vec<f64> = (0..trained.parameters.len()).map(shared).collect();
                let by_shared = trained.linear.0.predicts(&shared);
                let less: Vec<f64> = (there.iter().zip(here).zip(&by_shared))
                    .map(|((there, here), more)| (here - there) / step - more)
                    .collect();
                if k + 2 >= chain.len() {
                    found.push(less);
                    continue;
                }
                for (j, z) in trained.linear.0.moved(&less).step.iter().enumerate() {
                    let (p, moved) = (&trained.parameters[j], z * trained.slope(j));
                    match drift.iter_mut().find(|(name, _)| *name == p.name) {
                        Some((_, known)) => *known += moved,
                        None => drift.push((&p.name, moved)),
                    }
                }
            }
            Ok(found)
        };
        let total = two[0].1.observed.first()?.conditions.layout.length;
        let alone = chain.len() == 2 && !stage.channels;
        let count = lengths(&mut self.study.rig.clone(), alone).len();
        let one = |k: usize| {
            let (what, less) = [STEP, -STEP].into_iter().find_map(|step| {
                let mut study = self.study.clone();
                let mut exact = lengths(&mut study.rig, alone).swap_remove(k);
                exact.add(step);
                Some((exact.what, change(&study, step).ok()?))
            })?;
            let moving = moving(&what, two[0], &less[0]).filter(|m| m.by.abs() < LARGEST * total);
            let of = |model: usize, by: f64| {
                let data: Vec<f64> = less[model].iter().map(|g| g * by).collect();
                two[model].1.trained.linear.0.moved_with_noise(&data)
            };
            let by = least_root(&|by| lead + of(0, by) - of(1, by), LARGEST * total);
            Some((by.map(|by| LengthError { what, by }), moving))
        };
        let (smallest, moving): (Vec<_>, Vec<_>) =
            (0..count).into_par_iter().filter_map(one).collect::<Vec<_>>().into_iter().unzip();
        let mut smallest: Vec<LengthError> = smallest.into_iter().flatten().collect();
        smallest.sort_by(|a, b| a.by.abs().total_cmp(&b.by.abs()));
        smallest.truncate(TOLD);
        let mut moving: Vec<MovingLength> = moving.into_iter().flatten().collect();
        moving.sort_by(|a, b| a.by.abs().total_cmp(&b.by.abs()));
        moving.truncate(TOLD);
        Some(ExactLengths { models: two.map(|(model, _)| model.id.clone()), lead, smallest, moving })
    }

    /// What a model with its most probable parameters, moved by `step` times `drift`, predicts of every datum
    /// in the rig of `study`.
    pub(super) fn predicted(
        &self,
        study: &Study,
        stage: &Stage,
        model: &Chosen,
        drift: &[(&str, f64)],
        step: f64,
    ) -> Result<Vec<f64>, EngineError> {
        let used = model.used(&self.rig, stage);
        let observed = self.moved(study, &model.observed)?;
        let candidates = model.assembly.candidates().iter().filter(|c| c.role != "rig").cloned().collect();
        let assembly = Assembly::new(Arc::new(study.rig.clone()), candidates, &model.assembly.held())?;
        let moved = |(p, value): (&Parameter, &f64)| {
            value + step * drift.iter().find(|(name, _)| *name == p.name).map_or(0.0, |(_, by)| *by)
        };
        let values: Vec<f64> = assembly.parameters().iter().zip(&model.trained.values).map(moved).collect();
        let found = Predictor::new(&assembly, &observed, &used)?.predict(&values, Order::Value);
        let found = found.map_err(|error| EngineError::from(InferenceError::from(error)))?;
        Ok(model.trained.linear.1.iter().map(|place| found.values[*place]).collect())
    }

    /// These observations in the rig of `study`.
    fn moved(&self, study: &Study, observed: &[Observed]) -> Result<Vec<Observed>, EngineError> {
        let mut known: Vec<(String, Arc<crate::Conditions>)> = Vec::new();
        let one = |o: &Observed| {
            let point = &o.conditions.point;
            if let Some((_, conditions)) = known.iter().find(|(id, _)| *id == point.id) {
                return Ok(Observed { conditions: conditions.clone(), ..o.clone() });
            }
            let place = study.campaign.point(&point.id).map(|(k, _)| k);
            let state = place.and_then(|k| self.states.get(&k));
            let ambient = place.and_then(|k| self.ambient.get(k).copied().flatten());
            let conditions = Arc::new(conditions_or_ambient(study, point, state, ambient)?);
            known.push((point.id.clone(), conditions.clone()));
            Ok(Observed { conditions, ..o.clone() })
        };
        observed.iter().map(one).collect()
    }
}

/// The parameter of a model that moves most with a length, in its standard deviations, if the data read
/// `less` more for every metre.
fn moving(what: &str, (model, chosen): &(ModelRecord, Chosen), less: &[f64]) -> Option<MovingLength> {
    let trained = &chosen.trained;
    let steps = trained.linear.0.moved(less).step;
    let one = |(j, z): (usize, &f64)| {
        let p = &trained.parameters[j];
        let sd = model.parameters.iter().find(|known| known.name == p.name)?.sd;
        Some((z * trained.slope(j) / sd, p.name.clone()))
    };
    let all = steps.iter().enumerate().take(trained.own).filter_map(one);
    let (per_metre, parameter) = all.max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))?;
    let by = per_metre.recip();
    by.is_finite().then(|| MovingLength { what: what.to_owned(), by, parameter })
}

/// A length that is a plain number, or the diameter whose areas are.
struct Exact<'a> {
    what: String,
    numbers: Vec<&'a mut f64>,
    is_diameter: bool,
}

impl Exact<'_> {
    /// Makes it longer by `step`, m.
    fn add(&mut self, step: f64) {
        for number in &mut self.numbers {
            **number = match self.is_diameter {
                true => 0.25 * PI * ((**number * 4.0 / PI).sqrt() + step).powi(2),
                false => **number + step,
            };
        }
    }
}

/// The lengths, diameters and places of a rig that are plain numbers, by name; those of microphones if they
/// are `asked` about.
fn lengths(rig: &mut Rig, asked: bool) -> Vec<Exact<'_>> {
    let mut all = Vec::new();
    let mut numbers: Vec<Exact<'_>> = Vec::new();
    for part in &mut rig.parts {
        let name = &part.name;
        let named: Vec<(String, &mut Value)> = match &mut part.shape {
            Shape::Duct(duct) => {
                if let [Value::Number(one), Value::Number(other)] = &mut duct.area {
                    let what = format!("diameter of `{name}`");
                    numbers.push(Exact { what, numbers: vec![one, other], is_diameter: true });
                }
                vec![(format!("length of `{name}`"), &mut duct.length)]
            }
            Shape::Device(at) => at.iter_mut().map(|at| (format!("place of `{name}`"), at)).collect(),
            Shape::Insert(from, to) => {
                vec![(format!("beginning of `{name}`"), from), (format!("end of `{name}`"), to)]
            }
        };
        all.extend(named);
    }
    let microphones = rig.microphones.names.iter().zip(&mut rig.microphones.at).filter(|_| asked);
    all.extend(microphones.map(|(name, at)| (format!("place of microphone `{name}`"), at)));
    for (what, value) in all {
        if let Value::Number(x) = value {
            numbers.push(Exact { what, numbers: vec![x], is_diameter: false });
        }
    }
    numbers
}

/// The root of `lead` that is least in size, up to `largest`: by steps of a fifth from a hundredth of a
/// millimetre each way, then by halves.
fn least_root(lead: &dyn Fn(f64) -> f64, largest: f64) -> Option<f64> {
    let sizes = std::iter::successors(Some(1e-5), |size| Some(size * 1.2)).take_while(|size| *size < largest);
    let turned = sizes.flat_map(|size| [size, -size]).find(|by| lead(*by) <= 0.0)?;
    let (mut low, mut high) = (turned / 1.2, turned);
    for _ in 0..20 {
        let middle = 0.5 * (low + high);
        if lead(middle) <= 0.0 { high = middle } else { low = middle }
    }
    Some(high)
}

#[cfg(test)]
mod tests {
    use super::least_root;

    #[test]
    fn exact_the_root_nearer_to_zero_is_taken() {
        let of = |f: &dyn Fn(f64) -> f64| least_root(f, 0.05);
        let near = |found: Option<f64>, root: f64| assert!((found.unwrap() - root).abs() < 1e-8, "{found:?}");
        near(of(&|d| (1.0 + 1e3 * d) * (3.0 - 2e3 * d)), -1e-3);
        near(of(&|d| 3.0 - 2e3 * d), 1.5e-3);
        near(of(&|d| 3.0 - 1e7 * d * d), 3e-7_f64.sqrt());
        assert_eq!(of(&|d| 3.0 + d * d), None);
        assert_eq!(of(&|d| 3.0 - d), None);
    }
}
