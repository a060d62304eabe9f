//! Noise of a floor and of a part that grows with the modulus: whether the data ask for it, and the training
//! of a model with it. Of a quotient of two pressures that part may be what equal noise in both makes.
//!
//! The modulus is that of what the model says of each number, at the end of the last fit, and the fit is
//! repeated until it stays. By the measured modulus a number that noise made large would count for less, and
//! the gain would come out too small by twice the square of the relative noise. The fit does not ask how the
//! noise changes with the parameters: a parameter is told by the numbers, and not by their scatter.

use super::ground::Learned;
use super::head::Rest;
use super::measured::{Measured, sessions};
use super::predict::Responses;
use super::record::ResponseModelRecord;
use super::residual::{NOT_NOISE, left};
use super::train::{Found, ResponseTraining};
use super::{IN_PROPORTION, NOISE, OF_ONE_SIZE, OF_QUOTIENT};
use crate::EngineError;
use rayon::prelude::*;
use rijke_inference::NoiseEstimate;
use rijke_numerics::{C64, Grows, InOrder, Jet, Order, TwoPart};
use rijke_study::plan::SdSpec;
use rijke_study::responses::{ResponseKind, ResponseStage};

/// Most trainings until the ratio of the parts has settled, and most models that tell it.
const ROUNDS: usize = 4;
/// A number of which a fit leaves less counts as if it left so much.
const LEAST_LEFT: f64 = 0.05;
/// Change of ln of a variance from fit to fit at which the variances have settled.
const SETTLED: f64 = 2e-3;
/// Most fits until they settle, and those after which they move half as far.
const FITS: usize = 20;
const WHOLE_STEPS: usize = 5;

/// The models of a stage, and what was learned of each.
type Trained = (Vec<ResponseModelRecord>, Vec<Option<Learned>>);

/// The training of a model with a noise, that starts at what is told of every number.
type Again<'a> = dyn Fn(usize, &TwoPart, &[Vec<C64>]) -> Result<(ResponseModelRecord, Option<Learned>), EngineError>
    + Sync
    + 'a;

/// How the noise of what was measured may grow with its modulus; pressures of unknown sources, which are
/// divided by their level, with the inverse of that.
pub(super) fn ways(whats: &[ResponseKind]) -> &'static [Grows] {
    let is_quotient = |what: &ResponseKind| matches!(what, ResponseKind::Transfer { .. });
    let is_pressure = |what: &ResponseKind| matches!(what, ResponseKind::Pressure { .. });
    if whats.iter().all(is_quotient) {
        &[Grows::AsModulus, Grows::AsQuotient]
    } else if whats.iter().all(is_pressure) {
        &[Grows::AsInverse]
    } else if whats.iter().any(is_pressure) {
        &[]
    } else {
        &[Grows::AsModulus]
    }
}

/// The models of a stage as they were `trained`, or trained `again` with a noise that has a part that grows
/// in one of these `ways`, if the data ask for it. The ratio of the two parts is the same for all models,
/// as the best of them has it, so that their evidence can be compared; each floats the size of both.
///
/// # Errors
/// Those of `again`.
pub(super) fn with_the_noise_asked_for(
    stage: &ResponseStage,
    (measured, ways): (&[Measured], &[Grows]),
    trained: Trained,
    again: &Again<'_>,
) -> Result<Trained, EngineError> {
    let Some(Asked { mut noise, mut by, is_noise }) = asked(stage, (measured, ways), &trained) else {
        return Ok(trained);
    };
    let (mut models, mut found) = trained;
    for _ in 0..ROUNDS {
        let start = |model: &ResponseModelRecord| {
            heard_by(model).unwrap_or_else(|| measured.iter().map(|m| m.values.clone()).collect())
        };
        // Of the model that asks alone: with the noise that suits its residuals these are others.
        let mut start_of_it = start(&models[by]);
        for _ in 0..ROUNDS {
            let (model, learned) = again(by, &noise, &start_of_it)?;
            // What is left is no noise this way either.
            if !is_noise && correlates_by(&model, measured, &noise) {
                return Ok((models, found));
            }
            let (other, gain) = better((measured, ways), (&model, &learned), &noise);
            start_of_it = heard_by(&model).unwrap_or(start_of_it);
            if gain < TwoPart::SETTLED {
                break;
            }
            noise = other;
        }
        let one = |k: usize| again(k, &noise, &start(&models[k]));
        let next: Trained =
            (0..models.len()).into_par_iter().map(one).in_order::<Result<_, EngineError>>()?;
        let worth = |k: &usize| next.0[*k].ln_evidence();
        let fitted = (0..models.len()).filter(|k| next.1[*k].is_some());
        let Some(best) = fitted.max_by(|a, b| worth(a).total_cmp(&worth(b))) else { break };
        (models, found) = next;
        let (other, gain) = better((measured, ways), (&models[best], &found[best]), &noise);
        if best == by || gain < TwoPart::SETTLED {
            break;
        }
        (noise, by) = (other, best);
    }
    Ok((models, found))
}

/// Whether a stage may ask for a part that grows: where nothing is stated of its noise.
fn may_ask(stage: &ResponseStage, measured: &[Measured]) -> bool {
    matches!(stage.noise, SdSpec::Floated)
        && stage.misfit.is_none()
        && stage.noise_in_proportion != Some(false)
        && measured.iter().all(|m| m.sd.is_empty())
}

/// A noise that the data ask for.
struct Asked {
    noise: TwoPart,
    /// The model that tells it.
    by: usize,
    /// Whether what this model leaves is noise, by either.
    is_noise: bool,
}

/// The noise that the data ask for, if it has a part that grows, by the model that would have most evidence
/// with it. Models that leave what is no noise come after all others: a few loud numbers may draw them away
/// from all quiet ones.
fn asked(
    stage: &ResponseStage,
    (measured, ways): (&[Measured], &[Grows]),
    (models, found): &Trained,
) -> Option<Asked> {
    if !may_ask(stage, measured) {
        return None;
    }
    let best = models.iter().map(ResponseModelRecord::ln_evidence).fold(f64::NEG_INFINITY, f64::max);
    let of = |(by, (model, found)): (usize, (&ResponseModelRecord, &Option<Learned>))| {
        let heard = heard_by(model)?;
        let (noise, gain) = TwoPart::among(ways, &residuals(measured, &heard, &found.as_ref()?.left));
        // Either way: where quiet numbers count for much, those of a fit to the loud ones correlate.
        let is_noise =
            !correlates_by(model, measured, &TwoPart::white()) || !correlates_by(model, measured, &noise);
        Some((model.ln_evidence() + gain, gain, Asked { noise, by, is_noise }))
    };
    let least = if stage.noise_in_proportion == Some(true) { 0.0 } else { TwoPart::ASKED };
    let all = models.iter().zip(found).enumerate().filter_map(of);
    let asks = all.filter(|(with, gain, _)| *gain > least && *with > best + least);
    let most = asks.max_by(|a, b| a.2.is_noise.cmp(&b.2.is_noise).then(a.0.total_cmp(&b.0)));
    most.map(|(_, _, asked)| asked)
}

/// Whether neighbours of what a model leaves correlate, each by its variance with this noise.
fn correlates_by(model: &ResponseModelRecord, measured: &[Measured], noise: &TwoPart) -> bool {
    let Some(heard) = heard_by(model) else { return true };
    let measured = scaled(measured, &heard, noise);
    left(&measured, heard, Rest { noise: &model.noise, kernel: None }).neighbours_sds > NOT_NOISE
}

/// By how many nats another noise would suit the residuals of a model better than the one it was judged with,
/// and that noise.
fn better(
    (measured, ways): (&[Measured], &[Grows]),
    (model, found): (&ResponseModelRecord, &Option<Learned>),
    noise: &TwoPart,
) -> (TwoPart, f64) {
    let (Some(heard), Some(found)) = (heard_by(model), found) else { return (*noise, 0.0) };
    let rows = residuals(measured, &heard, &found.left);
    let (other, gain) = TwoPart::among(ways, &rows);
    (other, gain - noise.gain(&rows))
}

/// What a model says of every number; none of one that could not be fitted.
fn heard_by(model: &ResponseModelRecord) -> Option<Vec<Vec<C64>>> {
    let complex = |all: &Vec<[f64; 2]>| all.iter().map(|[re, im]| C64::new(*re, *im)).collect();
    model.evidence.map(|_| model.heard.iter().map(complex).collect())
}

/// With what the noise of every number may grow, the square of its residual, and the share that the fit left.
fn residuals(measured: &[Measured], heard: &[Vec<C64>], left: &[f64]) -> Vec<[f64; 3]> {
    let values = measured.iter().flat_map(|m| &m.values).zip(heard.iter().flatten());
    let with = measured.iter().zip(heard).flat_map(|(m, heard)| grows_with(m, heard));
    values.zip(with).zip(left).map(|(((z, h), with), left)| [with, (z - h).norm_sqr(), *left]).collect()
}

/// With what the noise of every number may grow: the modulus of what the model says, or the level of what
/// unknown sources make.
fn grows_with(m: &Measured, heard: &[C64]) -> Vec<f64> {
    if m.sources > 0 { m.level.clone() } else { heard.iter().map(|h| h.norm()).collect() }
}

/// The share of the variance of every number that a fit left to its residual: 1 less what the parameters take
/// of it, J C J' over that of the noise, for both parts together, and what unknown sources take. Empty where
/// no noise is asked for.
///
/// # Errors
/// Those of the model.
pub(super) fn left_by_the_fit(
    training: &ResponseTraining<'_>,
    found: &Found,
) -> Result<Vec<f64>, EngineError> {
    if !may_ask(training.stage, training.measured) {
        return Ok(Vec::new());
    }
    let answers = training.responses.answers(&found.fit.parameters, Order::First)?;
    let about = training.about(&found.fit)?;
    let covariance = &found.laplace.physical_covariance;
    let rest = Rest { noise: &found.fit.noise, kernel: None };
    let taken = |m: &Measured, i: usize, answer: &Jet| {
        let slopes = &answer.gradient()[..covariance.rows()];
        let part = |of: fn(&C64) -> f64| covariance.quadratic(&slopes.iter().map(of).collect::<Vec<_>>());
        let taken = (part(|z| z.re) + part(|z| z.im)) / (2.0 * rest.covariance_of(m, i, i));
        if taken > 0.0 { taken } else { 0.0 }
    };
    let mut left = Vec::new();
    for loads in sessions(training.measured) {
        let (own, count) = (&training.measured[loads.clone()], loads.len());
        if own[0].sources == 0 {
            let of_load = |(m, answers): (&Measured, &Vec<Jet>)| -> Vec<f64> {
                answers.iter().enumerate().map(|(i, answer)| 1.0 - taken(m, i, answer)).collect()
            };
            left.extend(own.iter().zip(&answers[loads]).flat_map(of_load));
            continue;
        }
        // All microphones of a row have one noise: what the sources take is shared among them.
        let told = about.told(training.measured, loads, &answers);
        let to_sources = own[0].sources as f64 / count as f64;
        let of_load = |(place, m): (usize, &Measured)| -> Vec<f64> {
            let one = |i: usize| 1.0 - to_sources - taken(m, i, &told[i * count + place]);
            (0..m.values.len()).map(one).collect()
        };
        left.extend(own.iter().enumerate().flat_map(of_load));
    }
    left.iter_mut().for_each(|left| *left = left.max(LEAST_LEFT));
    Ok(left)
}

/// The same numbers with the variances that the noise has where the model says `heard`.
fn scaled(measured: &[Measured], heard: &[Vec<C64>], noise: &TwoPart) -> Vec<Measured> {
    let one = |(m, heard): (&Measured, &Vec<C64>)| {
        let factor = grows_with(m, heard).into_iter().map(|with| noise.factor(with)).collect();
        Measured { factor, ..m.clone() }
    };
    measured.iter().zip(heard).map(one).collect()
}

/// The numbers with the variances of their noise, the responses at last ([`ResponseTraining::of_a_row`]), and
/// what training found.
type Settled<'r> = (Vec<Measured>, Option<Responses<'r>>, Found);

/// Trains a model with this noise until the variances are those of what it says itself; before the first fit
/// of what is `heard`.
///
/// # Errors
/// Those of [`ResponseTraining::of_a_row`], and [`EngineError::Unsettled`].
pub(super) fn settled<'r>(
    training: &ResponseTraining<'_>,
    noise: &TwoPart,
    heard: &[Vec<C64>],
    about: &dyn Fn(&[f64]) -> Result<Responses<'r>, EngineError>,
) -> Result<Settled<'r>, EngineError> {
    let quick = ResponseStage { checked: false, ..training.stage.clone() };
    let (mut stage, mut measured) = (&quick, scaled(training.measured, heard, noise));
    for fit in 0..FITS {
        let (at_last, found) =
            ResponseTraining { measured: &measured, stage, ..*training }.of_a_row(about)?;
        let mut next = scaled(training.measured, &found.heard, noise);
        let factors = || measured.iter().zip(&next).flat_map(|(a, b)| a.factor.iter().zip(&b.factor));
        let moved = factors().map(|(a, b)| (b / a).ln().abs()).fold(0.0, f64::max);
        if moved < SETTLED && stage.checked == training.stage.checked {
            return Ok((measured, at_last, found));
        }
        if moved < SETTLED {
            stage = training.stage;
        }
        if fit >= WHOLE_STEPS {
            let halfway = |(next, m): (&mut Measured, &Measured)| {
                next.factor.iter_mut().zip(&m.factor).for_each(|(to, from)| *to = (*to * from).sqrt());
            };
            next.iter_mut().zip(&measured).for_each(halfway);
        }
        measured = next;
    }
    Err(EngineError::Unsettled {
        what: format!(
            "the noise that grows with the modulus does not settle in {FITS} fits: the predictions change from fit to fit; give every row its \
             standard deviation (a column `sd`), or write `noise_in_proportion = false`"
        ),
    })
}

/// What training found of the noise, as the floor and the part that grows.
pub(super) fn in_parts(found: &[NoiseEstimate], noise: &TwoPart) -> Vec<NoiseEstimate> {
    let [floor, share] = noise.parts();
    let both = |n: &NoiseEstimate| {
        if n.name != NOISE {
            return vec![n.clone()];
        }
        let part =
            |name: &str, of_it: f64| NoiseEstimate { name: name.into(), sd: n.sd * of_it, ..n.clone() };
        let grows = match noise.grows() {
            Grows::AsModulus => IN_PROPORTION,
            Grows::AsQuotient => OF_QUOTIENT,
            Grows::AsInverse => OF_ONE_SIZE,
        };
        vec![part(NOISE, floor), part(grows, share)]
    };
    found.iter().flat_map(both).collect()
}
