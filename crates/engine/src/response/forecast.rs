//! What the model of a stage of responses predicts, at points and frequencies that were measured or not.

use super::errors::{causes_at, moved};
use super::ground::Ground;
use super::predict::Load;
use super::select::Selected;
use crate::gaussian::handed_on;
use crate::{Assembly, EngineError};
use rijke_formula::{Context, Formula};
use rijke_network::NetworkError;
use rijke_numerics::{C64, Jet, Matrix, Order};
use rijke_study::responses::{ResponseKind, ResponseStage, Responses};
use rijke_study::{Candidate, Cause, Coefficient, STEP, Study, hertz};
use serde::Serialize;
use std::sync::Arc;

/// One complex number that a model predicts, with the standard deviation that its parameters and the stated
/// errors of the point leave, to first order; noise and misfit of a measurement are not in it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ResponseForecast {
    /// Operating point.
    pub point: String,
    /// What it is.
    pub what: String,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Real and imaginary part.
    pub value: [f64; 2],
    /// Variances of both, and their covariance.
    pub covariance: [f64; 3],
    /// Whether it is a reflection coefficient, of which there is an absorption.
    pub is_reflection: bool,
}

impl ResponseForecast {
    /// Standard deviations of real and imaginary part.
    #[must_use]
    pub fn sd(&self) -> [f64; 2] {
        [self.covariance[0].sqrt(), self.covariance[1].sqrt()]
    }

    /// The variance along a direction of the complex plane.
    fn along(&self, [x, y]: [f64; 2]) -> f64 {
        let [re, im, both] = self.covariance;
        (x * x * re + y * y * im + 2.0 * x * y * both).max(0.0)
    }

    /// Modulus and its standard deviation.
    #[must_use]
    pub fn modulus(&self) -> [f64; 2] {
        let [re, im] = self.value;
        let size = re.hypot(im);
        let sd = if size > 0.0 { self.along([re / size, im / size]).sqrt() } else { self.sd()[0] };
        [size, sd]
    }

    /// Phase and its standard deviation, rad; none where the number is not told from nothing.
    #[must_use]
    pub fn phase(&self) -> Option<[f64; 2]> {
        /// Standard deviations from nothing at which a phase begins to be one.
        const TOLD: f64 = 2.0;
        let [re, im] = self.value;
        let size = re.hypot(im);
        let sd = self.along([-im / size, re / size]).sqrt();
        (size > TOLD * sd.max(self.modulus()[1])).then(|| [im.atan2(re), sd / size])
    }

    /// Absorption coefficient 1 - |R|^2 and its standard deviation, that of the square of a normal number:
    /// var |R|^2 = 4 R' C R + 2 tr C^2.
    #[must_use]
    pub fn absorption(&self) -> Option<[f64; 2]> {
        let [re, im, both] = self.covariance;
        let variance = 4.0 * self.along(self.value) + 2.0 * (re * re + im * im + 2.0 * both * both);
        let square = self.value[0].powi(2) + self.value[1].powi(2);
        self.is_reflection.then(|| [1.0 - square, variance.sqrt()])
    }
}

impl Ground {
    /// What its best model predicts at the points `places` of the campaign of `study`: every kind of response
    /// that trained it but pressures of unknown sources, and the reflection of every end that has a law. At
    /// `frequency_hz`, or if there are none at those between which it was trained.
    ///
    /// # Errors
    /// [`EngineError::Damaged`] for a model that is not of the study; those of the model at a point.
    pub fn forecast(
        &self,
        study: &Study,
        observed: &Responses,
        places: &[usize],
        frequency_hz: &[f64],
    ) -> Result<Vec<ResponseForecast>, EngineError> {
        let damaged = || EngineError::Damaged { stage: self.id.clone() };
        let stage = study.plan.response(&self.id).ok_or_else(damaged)?;
        let best = self.models.first().ok_or_else(damaged)?;
        let candidate = |id: &String| study.catalogue.get(id).cloned().ok_or_else(damaged);
        let candidates: Vec<Candidate> = best.candidates.values().map(candidate).collect::<Result<_, _>>()?;
        let asked = asked(study, observed, stage, &candidates)?;
        let assembly = Assembly::new(Arc::new(study.rig.clone()), candidates, &stage.hold)?;
        let [(_, known), ..] = &best.maxima(&self.id)?[..] else { return Err(damaged()) };
        let place = |name: &str| known.names.iter().position(|known| known == name);
        let own = assembly.parameters().iter().map(|p| place(&p.name).ok_or_else(damaged));
        let own: Vec<usize> = own.collect::<Result<_, _>>()?;
        let values: Vec<f64> = own.iter().map(|k| known.mean[*k]).collect();
        let at_hz = match frequency_hz {
            [] => band(study, observed, stage)?,
            given => given.to_vec(),
        };
        let mut all = Vec::new();
        for point in places {
            let causes: Vec<Cause> = causes_at(study, *point)?.into_iter().collect();
            // An error of which nothing is known is one standard deviation by itself.
            let of_causes: Vec<Option<usize>> = causes.iter().map(|c| place(&handed_on(c))).collect();
            let expected = |cause: &Cause| place(&handed_on(cause)).map_or(0.0, |k| known.mean[k]);
            let covariance = joint(&known.covariance, &own, &of_causes);
            for (what, kind) in &asked {
                let at = |error: &dyn Fn(&Cause) -> f64, order| {
                    Load::new(&assembly, &moved(study, *point, error)?, kind, &at_hz)?.answer(&values, order)
                };
                let here = at(&expected, Order::First).map_err(|error| no_answer(&stage.id, what, error))?;
                let beside =
                    |cause: &Cause| at(&|c| expected(c) + if c == cause { STEP } else { 0.0 }, Order::Value);
                let beside: Vec<Vec<Jet>> = causes.iter().map(beside).collect::<Result<_, _>>()?;
                for (k, jet) in here.iter().enumerate() {
                    let slopes = jet.gradient()[..own.len()].iter().copied();
                    let of_errors = beside.iter().map(|there| (there[k].value() - jet.value()) / STEP);
                    let slopes: Vec<C64> = slopes.chain(of_errors).collect();
                    all.push(ResponseForecast {
                        point: study.campaign.points[*point].id.clone(),
                        what: what.clone(),
                        frequency_hz: at_hz[k],
                        value: [jet.value().re, jet.value().im],
                        covariance: spread(&covariance, &slopes),
                        is_reflection: is_reflection(kind),
                    });
                }
            }
        }
        Ok(all)
    }
}

/// The refusal of a frequency at which a model has no answer.
fn no_answer(stage: &str, what: &str, error: EngineError) -> EngineError {
    match error {
        EngineError::Network { source: NetworkError::NotFinite { s }, .. } => {
            let problem =
                format!("the model has no {what} at {:.1} Hz; choose lower frequencies", hertz(s.im));
            EngineError::Refused { stage: stage.to_owned(), problem }
        }
        other => other,
    }
}

/// What a stage is asked for, each with its name.
fn asked(
    study: &Study,
    observed: &Responses,
    stage: &ResponseStage,
    candidates: &[Candidate],
) -> Result<Vec<(String, ResponseKind)>, EngineError> {
    let microphones = &study.rig.microphones.names;
    let mut all: Vec<(String, ResponseKind)> = Vec::new();
    for what in Selected::new(study, observed, stage)?.whats {
        let name = match &what {
            ResponseKind::Pressure { .. } => continue,
            ResponseKind::Reflection { .. } => "reflection at upstream".to_owned(),
            ResponseKind::Transfer { to, from } => {
                format!("{} over {}", microphones[*to], microphones[*from])
            }
            ResponseKind::Law { at, coefficient, .. } => {
                let of_it = |c: &&Candidate| {
                    c.effects.iter().any(|e| e.coefficient == *coefficient && e.place == *at)
                };
                let role = candidates.iter().find(of_it).map_or("law", |c| c.role.as_str());
                format!("measured {} of {role}", coefficient.name())
            }
        };
        if !all.iter().any(|(_, known)| known.is_same(&what)) {
            all.push((name, what));
        }
    }
    let context = Context { scope: &study.rig.scope, here: &|_| true, parameters: &[], definitions: &[] };
    let one = Formula::parse("1", &context)
        .map_err(|e| EngineError::Refused { stage: stage.id.clone(), problem: e.to_string() })?;
    for effect in
        candidates.iter().flat_map(|c| &c.effects).filter(|e| e.coefficient == Coefficient::Reflection)
    {
        let (at, coefficient) = (effect.place.clone(), effect.coefficient);
        let kind = ResponseKind::Law { at, coefficient, factor: one.clone() };
        if !all.iter().any(|(_, known)| known.is_same(&kind)) {
            all.push((format!("reflection of the end {}", effect.place_text), kind));
        }
    }
    Ok(all)
}

fn is_reflection(kind: &ResponseKind) -> bool {
    matches!(
        kind,
        ResponseKind::Reflection { .. } | ResponseKind::Law { coefficient: Coefficient::Reflection, .. }
    )
}

/// The lowest and the highest frequency that trained a stage, Hz.
pub(crate) fn trained_band(
    study: &Study,
    observed: &Responses,
    stage: &ResponseStage,
) -> Result<[f64; 2], EngineError> {
    let data = Selected::new(study, observed, stage)?;
    let all = data.measured.iter().flat_map(|m| m.frequency_hz.iter().copied());
    Ok(all.fold([f64::INFINITY, 0.0], |[low, high], f| [low.min(f), high.max(f)]))
}

/// Evenly over the frequencies that trained a stage.
fn band(study: &Study, observed: &Responses, stage: &ResponseStage) -> Result<Vec<f64>, EngineError> {
    /// How many there are.
    const COUNT: usize = 101;
    let [low, high] = trained_band(study, observed, stage)?;
    Ok((0..COUNT).map(|k| low + (high - low) * k as f64 / (COUNT - 1) as f64).collect())
}

/// The joint covariance of some parameters and of errors, of which those that are not among the known have a
/// variance of 1 by themselves.
fn joint(known: &Matrix, own: &[usize], errors: &[Option<usize>]) -> Matrix {
    let all: Vec<Option<usize>> = own.iter().map(|k| Some(*k)).chain(errors.iter().copied()).collect();
    Matrix::from_fn(all.len(), all.len(), |i, j| match (all[i], all[j]) {
        (Some(a), Some(b)) => known[(a, b)],
        _ => f64::from(u8::from(i == j)),
    })
}

/// The variances of real and imaginary part of a number with these slopes, and their covariance.
fn spread(covariance: &Matrix, slopes: &[C64]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (i, a) in slopes.iter().enumerate() {
        for (j, b) in slopes.iter().enumerate() {
            let c = covariance[(i, j)];
            sum[0] += c * a.re * b.re;
            sum[1] += c * a.im * b.im;
            sum[2] += c * a.re * b.im;
        }
    }
    [sum[0].max(0.0), sum[1].max(0.0), sum[2]]
}
