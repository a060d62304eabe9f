//! The points of a study as places where something can be measured: what each would read, by a model and its
//! rival.

use super::predictive::{Numbers, Predictive, Shared};
use super::pressures::Listening;
use super::told::{Aim, Told};
use super::visit::Visit;
use crate::data::near_field;
use crate::noise::{measured_sd, of_point_and_installation, varying};
use crate::run::points::ready::{Known, Ready};
use crate::run::stages::average::OpenModel;
use crate::{Conditions, EngineError, Observed, SavedModel};
use rayon::prelude::*;
use rijke_numerics::{C64, Matrix};
use rijke_rig::{ChannelErrors, ModeRows};
use rijke_study::Study;
use rijke_study::plan::Stage;
use std::collections::BTreeSet;

/// Least share of the variance of a misfit that is drawn anew: what was measured without error could else not
/// be repeated.
const ANEW: f64 = 1e-6;

/// What is wanted of [`next`](super::next).
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
    /// Whether growth rates and frequencies alone are measured, and no relative pressures, though these
    /// trained.
    pub without_pressures: bool,
}

/// What is known of the points of a study, whichever model is asked, and of its microphones.
pub(super) struct Place<'a> {
    known: Known<'a>,
    channels: Option<ChannelErrors>,
}

impl<'a> Place<'a> {
    /// `channels` are the errors of the microphones of the study's folder; the study may have more of them.
    pub(super) fn new(known: Known<'a>, channels: Option<ChannelErrors>) -> Self {
        Self { known, channels }
    }

    pub(super) fn study(&self) -> &Study {
        self.known.study
    }

    pub(super) fn observed(&self) -> &[Observed] {
        &self.known.observed
    }

    /// The modes that a visit of a point measures, with the place where each is sought: those that were
    /// measured there, else all that trained the model.
    fn modes(
        &self,
        ready: &Ready<'_>,
        conditions: &Conditions,
    ) -> Result<Vec<(String, Option<C64>)>, EngineError> {
        let here = self.observed().iter().filter(|o| o.conditions.id == conditions.id);
        let measured: Vec<_> = here.map(|o| (o.mode.label.clone(), Some(o.near))).collect();
        if !measured.is_empty() {
            return Ok(measured);
        }
        let sought = ready.followed.sought(&ready.assembly, ready.values(), conditions)?;
        Ok(sought.into_iter().map(|mode| (mode.label, mode.near)).collect())
    }

    /// A mode at a point by a model.
    fn numbers(
        &self,
        Ready { model, posterior, assembly, .. }: &Ready<'_>,
        conditions: &Conditions,
        near: Option<C64>,
        microphones: &[usize],
    ) -> Result<Numbers, EngineError> {
        let (known, law) = (&posterior.gaussian, model.law.as_ref());
        let linear = posterior.linear(known, assembly, conditions, microphones, near, law)?;
        // Repeated visits of a point share the errors of its gas: some of them are made anew, but this
        // promises less.
        let shared = linear.base.into_iter().chain(linear.law).map(|(c, change)| (Shared::Cause(c), change));
        let mut numbers = Numbers {
            noise: Matrix::zeros(linear.values.len(), linear.values.len()),
            stays: Matrix::zeros(linear.values.len(), linear.values.len()),
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

    /// What measuring each point would give of each of its modes.
    pub(super) fn expected(
        &self,
        stage: &Stage,
        model: &SavedModel,
        candidates: &[usize],
        microphones: &[usize],
    ) -> Result<Vec<Result<Visit, EngineError>>, EngineError> {
        let ready = Ready::of(&self.known, model)?;
        let posterior = &ready.posterior;
        let trained = self.trained(model);
        let measured = stage.noise_of_predictions.as_ref().unwrap_or(&stage.noise).measured;
        let errors = [0, 1].map(|k| if measured { measured_sd(&trained, k) } else { 0.0 });
        let noise = of_point_and_installation(&posterior.noise);
        let rig = &self.study().rig;
        let channels = self.channels.as_ref();
        let listening =
            |errors| Listening::of(self.study(), stage, channels, &trained, &posterior.gaussian, errors);
        let heard = listening(measured)?;
        // Where the measured errors do not come on top of the misfit, they are the part of it that a repeat
        // draws anew.
        let hidden = match measured {
            true => [0.0; 3],
            false => {
                [measured_sd(&trained, 0).powi(2), measured_sd(&trained, 1).powi(2), listening(true)?.usual()]
            }
        };
        let misfit = [0, 1, 2].map(|k| noise[k][0].powi(2).max(hidden[k]));
        let anew = [0, 1, 2].map(|k| hidden[k].max(ANEW * misfit[k]));
        let others: Vec<usize> =
            microphones.iter().copied().filter(|m| *m != rig.microphones.reference).collect();
        let one = |(label, near): &(String, Option<C64>), conditions: &Conditions| {
            let mut numbers = self.numbers(&ready, conditions, *near, microphones)?;
            let rows = numbers.values.len();
            let faults = |m: usize| misfit[2] + near_field(rig, conditions, m).powi(2);
            let [with, without] = [&faults as &dyn Fn(usize) -> f64, &|_| anew[2]]
                .map(|variance| heard.noise(&numbers, rig.microphones.reference, &others, variance));
            (numbers.stays, numbers.noise) = (with.plus(-1.0, &without), with);
            for r in 0..2 {
                numbers.stays[(r, r)] = misfit[r] - anew[r];
                numbers.noise[(r, r)] = misfit[r] + errors[r].powi(2);
            }
            heard.add_channels(&mut numbers, &others);
            for (r, [_, sd]) in noise.iter().enumerate().take(2).filter(|(_, [_, sd])| *sd > 0.0) {
                let cause = Shared::Installation(r, conditions.point.installation.clone());
                numbers.shared.insert(cause, (0..rows).map(|i| if i == r { *sd } else { 0.0 }).collect());
            }
            let same = |o: &&Observed| o.conditions.id == conditions.id && o.mode.label == *label;
            let Some(seen) = trained.iter().find(same) else {
                return Ok(numbers);
            };
            let used = seen.used(&others, rig.microphones.reference);
            // Where its pressures stand among those that are asked for.
            let place = |row: usize| match row.checked_sub(2) {
                None => row,
                Some(k) => {
                    let asked = others.iter().position(|m| *m == used.others[k / 2]).unwrap_or_default();
                    ModeRows::pressure(asked) + k % 2
                }
            };
            let read = used.rows.iter().map(|row| place(*row)).zip(&used.values);
            let read = read.filter(|(row, _)| numbers.stays[(*row, *row)] > 0.0);
            let (rows, residual): (Vec<usize>, Vec<f64>) =
                read.map(|(row, value)| (row, value - numbers.values[row])).unzip();
            numbers.repeated(&rows, &residual)
        };
        let visit = |&k: &usize| {
            let conditions = ready.conditions(k)?;
            let mut visit = Visit::default();
            for mode in self.modes(&ready, &conditions)? {
                let numbers = one(&mode, &conditions)?;
                visit.add(mode.0, numbers);
            }
            Ok(visit)
        };
        Ok(candidates.par_iter().map(visit).collect())
    }

    /// The observations that trained a model.
    pub(super) fn trained(&self, model: &SavedModel) -> Vec<Observed> {
        self.known.trained(model)
    }

    /// The microphones but the reference whose pressures trained a model.
    pub(super) fn heard(&self, model: &SavedModel) -> BTreeSet<usize> {
        let instruments = &self.study().rig.microphones;
        let stage = self.study().plan.stage(&model.stage).map(|(_, stage)| stage);
        let used = |m: &usize| stage.is_none_or(|s| s.hears(&instruments.names[*m]));
        let trained = self.trained(model);
        let heard = trained.iter().flat_map(|o| o.mode.pressures.iter().map(|(m, _)| *m));
        heard.filter(|m| *m != instruments.reference && used(m)).collect()
    }

    /// The points that can be judged, with what measuring each would give.
    pub(super) fn measurable(
        &self,
        model: &SavedModel,
        rivals: &[OpenModel],
        wish: &Wish,
        microphones: &[usize],
    ) -> Result<Measurable, EngineError> {
        let nothing = |reason: String| EngineError::NothingToMeasure { stage: model.stage.clone(), reason };
        let Some((_, stage)) = self.study().plan.stage(&model.stage) else {
            return Err(nothing("the study has no such stage; rank it again".into()));
        };
        let mine = self.expected(stage, model, &wish.candidates, microphones)?;
        let expected = |rival: &OpenModel| self.expected(stage, &rival.model, &wish.candidates, microphones);
        let theirs = rivals.iter().map(expected).collect::<Result<Vec<_>, _>>()?;
        let mut theirs: Vec<_> = theirs.into_iter().map(Vec::into_iter).collect();
        let known = |m: &SavedModel| Ok::<_, EngineError>(m.posterior()?.gaussian.covariance);
        let mut able = Measurable {
            kept: Vec::new(),
            own: Vec::new(),
            rivals: Vec::new(),
            about: wish.about.map(|k| self.wanted(model, k, &wish.candidates, &mine)).transpose()?,
            covariance: known(model)?,
            left_out: Vec::new(),
        };
        for rival in rivals {
            able.rivals.push(Rival {
                odds: rival.odds,
                covariance: known(&rival.model)?,
                numbers: Vec::new(),
            });
        }
        // Who has measured growth can measure it elsewhere.
        let grows = |o: &Observed| o.mode.growth_rate.is_some_and(|growth| growth > 0.0);
        let decays_only = !self.trained(model).iter().any(grows);
        for (&k, own) in wish.candidates.iter().zip(mine) {
            let others: Result<Vec<Visit>, EngineError> =
                theirs.iter_mut().filter_map(Iterator::next).collect();
            let why = match (own, others) {
                (Ok(own), Ok(_)) if own.fastest() > 0.0 && decays_only => format!(
                    "the model says that the mode grows there, by {:.2} 1/s: it rings by itself, and has no decay to be measured",
                    own.fastest()
                ),
                (Ok(mut own), Ok(mut others)) => {
                    Visit::keep_common(others.iter_mut().chain([&mut own]));
                    if own.0.is_empty() {
                        "the models have no mode in common there".into()
                    } else {
                        able.kept.push(k);
                        able.own.push(own);
                        let all = able.rivals.iter_mut().zip(others);
                        all.for_each(|(rival, numbers)| rival.numbers.push(numbers));
                        continue;
                    }
                }
                (Err(e), _) | (_, Err(e)) => e.to_string(),
            };
            able.left_out.push((self.study().campaign.points[k].id.clone(), why));
        }
        if able.kept.is_empty() {
            let reason = able.left_out.into_iter().next().map(|(_, reason)| reason);
            return Err(nothing(reason.unwrap_or_else(|| "no point is given".into())));
        }
        match (wish.aim, able.rivals.first(), &able.about) {
            (Aim::Models, None, _) => {
                Err(nothing("only one model of it could be fitted: there is nothing to decide".into()))
            }
            (Aim::Quantity, _, None) => Err(nothing("no point is given whose growth rate is wanted".into())),
            _ => Ok(able),
        }
    }

    /// The growth rate at a point in an installation of its own, without noise. As in a prediction, it has an
    /// error of its base state in common with the visits if several of their points name it: what only one
    /// names, the reading of one point for instance, is drawn anew.
    fn wanted(
        &self,
        model: &SavedModel,
        k: usize,
        candidates: &[usize],
        visits: &[Result<Visit, EngineError>],
    ) -> Result<Numbers, EngineError> {
        let ready = Ready::of(&self.known, model)?;
        let conditions = ready.conditions(k)?;
        let near = self.modes(&ready, &conditions)?.into_iter().next().and_then(|(_, near)| near);
        let numbers = self.numbers(&ready, &conditions, near, &[])?;
        let common = |cause: &Shared| {
            let names = |visit: &Result<Visit, EngineError>| {
                visit.as_ref().is_ok_and(|v| v.0.iter().any(|(_, mode)| mode.shared.contains_key(cause)))
            };
            let named = candidates.iter().zip(visits).filter(|(_, visit)| names(visit)).map(|(&k, _)| k);
            named.collect::<BTreeSet<_>>().len() > 1
        };
        let apart = |cause: Shared| match cause {
            Shared::Varying(name, _) => Shared::Varying(name, String::new()),
            Shared::Cause(own) if !common(&Shared::Cause(own.clone())) => Shared::Anew(own),
            other => other,
        };
        let first = Matrix::from_fn(1, numbers.values.len(), |_, j| f64::from(u8::from(j == 0)));
        let mut wanted = numbers.through(&first);
        wanted.shared = wanted.shared.into_iter().map(|(cause, slope)| (apart(cause), slope)).collect();
        Ok(wanted)
    }
}

/// The points that can be judged.
pub(super) struct Measurable {
    /// Their places in the campaign.
    pub(super) kept: Vec<usize>,
    /// By the model.
    pub(super) own: Vec<Visit>,
    /// By the others, the most probable first.
    rivals: Vec<Rival>,
    about: Option<Numbers>,
    covariance: Matrix,
    /// Points that cannot be judged, and why.
    pub(super) left_out: Vec<(String, String)>,
}

/// What another model says of the points that can be judged.
struct Rival {
    /// Its odds against the model that went on.
    odds: f64,
    /// What it knows.
    covariance: Matrix,
    numbers: Vec<Visit>,
}

impl Measurable {
    /// What visits of the points would tell, if `seen` says what is measured of the numbers of each mode.
    pub(super) fn told(&self, seen: &(dyn Fn(&Numbers) -> Numbers + Sync)) -> Told {
        // The quantity stands behind all points.
        let own = self.own.iter().map(|visit| visit.seen(seen)).chain(self.about.clone()).collect();
        let rival = |r: &Rival| {
            let numbers = r.numbers.iter().map(|visit| visit.seen(seen)).collect();
            (r.odds, Predictive::new(numbers, &r.covariance))
        };
        Told {
            mine: Predictive::new(own, &self.covariance),
            rivals: self.rivals.par_iter().map(rival).collect(),
            quantity: self.about.is_some().then_some(self.kept.len()),
        }
    }
}
