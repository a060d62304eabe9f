//! Errors of what the campaign and the rig state, factors and temperatures, as parameters of a stage of
//! responses: each in its standard deviations, with a prior of 0 +- 1 or what an earlier stage tells.
//!
//! Every cause of error is one number for all points that share it. With the parameters x of the model the
//! answers are R(x, e) = R(x, e0) + (e - e0) (R_e + R_ex (x - x0)) + (e - e0)^2 R_ee / 2 about the values x0
//! and e0 of the last fit, where R(x, e0) is that of the rig with the factors and the temperatures moved, and
//! R_e, R_ex and R_ee follow from small steps to both sides ([`rijke_study::STEP`]). The fit is repeated
//! until the parameters stay. So Laplace's method has all second derivatives of the cost: where an error and
//! a parameter make up for each other, its width is a small difference of large ones, and slopes alone make
//! it wrong by half.

use crate::gaussian::handed_on;
use crate::run::{conditions_at, conditions_of, with_factors_moved};
use crate::{Conditions, EngineError};
use rijke_inference::{Parameter, Prior};
use rijke_numerics::{C64, Jet, JetSpace};
use rijke_study::{Cause, Study};
use std::collections::BTreeSet;

/// The errors of a stage.
#[derive(Clone, Debug, Default)]
pub(super) struct Errors {
    /// The causes, ascending.
    pub(super) causes: Vec<Cause>,
    /// e0 of each.
    pub(super) about: Vec<f64>,
    /// The parameters of the model at which the slopes were taken.
    pub(super) own: Vec<f64>,
    /// For every load the causes that move it, and how each of its numbers changes with them.
    pub(super) slopes: Vec<Vec<(usize, Vec<Slope>)>>,
    /// For every load the mixed second derivatives of its numbers in two causes.
    pub(super) mixed: Vec<Vec<([usize; 2], Vec<C64>)>>,
}

/// How a number changes with an error: derivatives per standard deviation.
#[derive(Clone, Debug)]
pub(super) struct Slope {
    first: C64,
    second: C64,
    /// Of the first in the parameters of the model.
    by_own: Vec<C64>,
}

impl Slope {
    /// From a number where the error is smaller by `step`, as it stands, and larger, all with derivatives in
    /// the `own` parameters of the model.
    pub(super) fn between([below, here, above]: [&Jet; 3], step: f64, own: usize) -> Self {
        let per = |(a, b): (&C64, &C64)| (a - b) / (2.0 * step);
        Self {
            first: per((&above.value(), &below.value())),
            second: (above.value() - 2.0 * here.value() + below.value()) / (step * step),
            by_own: above.gradient()[..own].iter().zip(&below.gradient()[..own]).map(per).collect(),
        }
    }

    /// What an `error` that is counted from where the slope was taken adds, at parameters that are `moved`
    /// from there.
    fn times(&self, error: &Jet, moved: &[f64], space: JetSpace) -> Jet {
        let mut slope = space.constant(self.first);
        slope.add_scaled(error, 0.5 * self.second);
        for (i, (by, moved)) in self.by_own.iter().zip(moved).enumerate() {
            slope.add_scaled(&space.seed(i, C64::from(*moved)), *by);
        }
        error * &slope
    }
}

/// The mixed second derivatives of numbers in two errors: from where both are larger by `step`, each alone,
/// and as they stand.
pub(super) fn mixed_between(both: &[Jet], [one, other]: [&[Jet]; 2], here: &[Jet], step: f64) -> Vec<C64> {
    let of = |k: usize| both[k].value() - one[k].value() - other[k].value() + here[k].value();
    (0..here.len()).map(|k| of(k) / (step * step)).collect()
}

impl Errors {
    /// Those of the operating points `points`, and others that are `known`; of no effect yet.
    ///
    /// # Errors
    /// Those of the conditions of a point.
    pub(super) fn of(study: &Study, points: &[usize], known: &[Cause]) -> Result<Self, EngineError> {
        let mut causes: BTreeSet<Cause> = known.iter().cloned().collect();
        for point in points.iter().collect::<BTreeSet<_>>() {
            causes.extend(causes_at(study, *point)?);
        }
        let causes: Vec<Cause> = causes.into_iter().collect();
        Ok(Self {
            about: vec![0.0; causes.len()],
            own: Vec::new(),
            slopes: Vec::new(),
            mixed: Vec::new(),
            causes,
        })
    }

    pub(super) fn is_none(&self) -> bool {
        self.causes.is_empty()
    }

    /// As parameters, in standard deviations.
    pub(super) fn parameters(&self) -> Vec<Parameter> {
        let prior = Prior::Normal { mean: 0.0, sd: 1.0 };
        let one =
            |(k, cause): (usize, &Cause)| Parameter::new(called(cause), format!("e_{}", k + 1), "sd", prior);
        self.causes.iter().enumerate().map(one).collect()
    }

    /// What a parameter is called from stage to stage: one of these by its cause.
    pub(super) fn handed_on(&self, name: &str) -> String {
        let cause = self.causes.iter().find(|cause| called(cause) == name);
        cause.map_or_else(|| name.to_owned(), handed_on)
    }

    /// What a parameter that is handed on is called here.
    pub(super) fn here(&self, name: &str) -> String {
        let cause = self.causes.iter().find(|cause| handed_on(cause) == name);
        cause.map_or_else(|| name.to_owned(), called)
    }

    /// e0 of a cause; 0 of one that is none of these.
    pub(super) fn value(&self, cause: &Cause) -> f64 {
        self.causes.binary_search(cause).map_or(0.0, |k| self.about[k])
    }

    /// The answers of load `load` with the errors `values`. They have derivatives in the parameters of the
    /// model, which are `own`, and in s; what comes out has those in these, in the errors, and zero
    /// for the one in s.
    pub(super) fn with(&self, load: usize, answers: &[Jet], own: &[f64], values: &[f64]) -> Vec<Jet> {
        let slopes = self.slopes.get(load).map_or(&[][..], Vec::as_slice);
        let mixed = self.mixed.get(load).map_or(&[][..], Vec::as_slice);
        let moved: Vec<f64> = own.iter().zip(&self.own).map(|(here, there)| here - there).collect();
        let own = own.len();
        let one = |(k, answer): (usize, &Jet)| {
            let space = JetSpace::new(own + values.len() + 1, answer.order());
            let mut wide = space.take(answer, |i| (i < own).then_some(i));
            let error = |cause: usize| space.seed(own + cause, C64::from(values[cause] - self.about[cause]));
            for (cause, slope) in slopes {
                let error = error(*cause);
                wide += &slope[k].times(&error, &moved, space);
            }
            for ([a, b], second) in mixed {
                wide.add_scaled(&(&error(*a) * &error(*b)), second[k]);
            }
            wide
        };
        answers.iter().enumerate().map(one).collect()
    }
}

/// The causes of error of an operating point.
pub(super) fn causes_at(study: &Study, point: usize) -> Result<BTreeSet<Cause>, EngineError> {
    let conditions = conditions_at(study, point)?;
    let stated = &study.campaign.points[point];
    let ambient = stated.ambient.filter(|[_, sd]| *sd > 0.0).map(|_| Cause::ambient(stated));
    let of_state = conditions.base.errors.into_iter().map(|e| e.cause);
    Ok(conditions.displaced.into_iter().map(|d| d.cause).chain(of_state).chain(ambient).collect())
}

/// The conditions of an operating point with every cause of `error` at so many of its standard deviations.
pub(super) fn moved(
    study: &Study,
    k: usize,
    error: &dyn Fn(&Cause) -> f64,
) -> Result<Conditions, EngineError> {
    let stated = &study.campaign.points[k];
    let mut point = with_factors_moved(study, stated, &conditions_at(study, k)?, error);
    point.factor_sds.fill(0.0);
    if let Some([temperature, sd]) = &mut point.ambient {
        *temperature += error(&Cause::ambient(stated)) * *sd;
    }
    let conditions = conditions_of(study, &point)?;
    // The ambient temperature is moved already, with all that depends on it.
    let own = |cause: &Cause| if matches!(cause, Cause::Ambient(_)) { 0.0 } else { error(cause) };
    let along: Vec<f64> = conditions.base.errors.iter().map(|e| own(&e.cause)).collect();
    Ok(Conditions { base: conditions.base.displaced(&along), ..conditions })
}

/// What the parameter of a cause of error is called.
fn called(cause: &Cause) -> String {
    format!("error of {cause}")
}
