//! The errors of what is stated ([`super::errors`]), taken where the fit ends.

use super::errors::{Errors, causes_at, moved as conditions_moved};
use super::predict::{Load, Responses, clear};
use super::select::Selected;
use super::stage::ResponseRun;
use super::train::{Found, Training, moved};
use crate::{Assembly, EngineError};
use rijke_numerics::Order;
use rijke_study::responses::ResponseStage;
use rijke_study::{Cause, STEP};
use std::collections::BTreeSet;

/// Movement of the parameters from fit to fit, in their standard deviations, at which the errors of what is
/// stated have settled: what is left out is of its square.
const STAYS: f64 = 0.05;
/// Most fits until they settle.
const FITS: usize = 50;

impl ResponseRun {
    /// The loads of a stage, at points whose errors are what `errors` are taken about.
    pub(super) fn loads<'a>(
        &self,
        assembly: &'a Assembly,
        data: &Selected,
        errors: &Errors,
    ) -> Result<Vec<Load<'a>>, EngineError> {
        (0..data.points.len()).map(|load| self.load(assembly, data, load, &|c| errors.value(c))).collect()
    }

    fn load<'a>(
        &self,
        assembly: &'a Assembly,
        data: &Selected,
        load: usize,
        error: &dyn Fn(&Cause) -> f64,
    ) -> Result<Load<'a>, EngineError> {
        let conditions = conditions_moved(&self.study, data.points[load], error)?;
        Load::new(assembly, &conditions, &data.whats[load], &data.measured[load].frequency_hz)
    }

    /// The same responses, with their errors taken about these values of all parameters.
    ///
    /// # Errors
    /// Those of the model at moved factors and temperatures.
    pub(super) fn about<'a>(
        &self,
        assembly: &'a Assembly,
        data: &Selected,
        responses: &Responses<'a>,
        values: &[f64],
    ) -> Result<Responses<'a>, EngineError> {
        let (own, rest) = values.split_at(responses.own);
        let mut errors = responses.errors.clone();
        errors.about = rest[..errors.causes.len()].to_vec();
        let loads = self.loads(assembly, data, &errors)?;
        let here = clear(&loads, own, Order::Value)?;
        let mut slopes = vec![Vec::new(); loads.len()];
        for point in data.points.iter().collect::<BTreeSet<_>>() {
            let of_point: Vec<usize> = (0..loads.len()).filter(|l| data.points[*l] == *point).collect();
            for cause in causes_at(&self.study, *point)? {
                let Ok(k) = errors.causes.binary_search(&cause) else { continue };
                let beside = |c: &Cause| errors.value(c) + if *c == cause { STEP } else { 0.0 };
                let there = of_point.iter().map(|l| self.load(assembly, data, *l, &beside));
                let there = clear(&there.collect::<Result<Vec<_>, _>>()?, own, Order::Value)?;
                for (load, there) in of_point.iter().zip(there) {
                    let pairs = there.iter().zip(&here[*load]);
                    let slope = pairs.map(|(t, h)| (t.value() - h.value()) / STEP).collect();
                    slopes[*load].push((k, slope));
                }
            }
        }
        errors.slopes = slopes;
        Ok(Responses { loads, errors, own: responses.own, channels: responses.channels.clone() })
    }
}

impl Training<'_> {
    /// As [`Training::found`], with the errors of what is stated taken where the fit ends: `about` are the
    /// responses with these errors about values of all parameters, and returned as they were last, if there
    /// are errors.
    ///
    /// # Errors
    /// As [`Training::found`], those of `about`, and [`EngineError::Unsettled`] where the errors do not
    /// settle.
    pub(super) fn with_errors<'r>(
        &self,
        about: &dyn Fn(&[f64]) -> Result<Responses<'r>, EngineError>,
    ) -> Result<(Option<Responses<'r>>, Found), EngineError> {
        if self.responses.errors.is_none() {
            return Ok((None, self.found()?));
        }
        let quick = ResponseStage { checked: false, ..self.stage.clone() };
        // Without errors there need not be a fit.
        let mut before = Training { stage: &quick, ..*self }.found().ok().map(|found| found.fit);
        let mut at = before.as_ref().map_or_else(|| self.middle(), |fit| fit.parameters.clone());
        let (mut stage, mut last, mut share) = (&quick, f64::INFINITY, 1.0_f64);
        for _ in 0..FITS {
            let responses = about(&at)?;
            let found = Training { responses: &responses, stage, ..*self }.found_from(before)?;
            let moved = moved(&found.laplace, &found.fit.parameters, &at);
            if moved < STAYS && (stage.checked || !self.stage.checked) {
                return Ok((Some(responses), found));
            }
            // A fit that moves much farther than the share of the one before left may go to and fro.
            share = if moved > (1.0 - 0.5 * share) * last { 0.5 * share } else { (1.5 * share).min(1.0) };
            at.iter_mut().zip(&found.fit.parameters).for_each(|(at, to)| *at += share * (to - *at));
            stage = if moved < STAYS { self.stage } else { &quick };
            (last, before) = (moved, Some(found.fit));
        }
        Err(EngineError::Unsettled {
            what: format!(
                "the stated errors of factors or temperatures are too large to be counted to first order: after {FITS} fits the parameters still \
                 move by {last:.2} standard deviations; make what is in error an unknown of the rig (`\"thickness + $off\"`)"
            ),
        })
    }
}
