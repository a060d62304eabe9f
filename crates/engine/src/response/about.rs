//! The errors of what is stated ([`super::errors`]), taken where the fit ends.

use super::errors::{Errors, Slope, causes_at, mixed_between, moved as conditions_moved};
use super::head::Rest;
use super::predict::{Load, Responses, clear};
use super::residual::POOR;
use super::residual::left;
use super::select::Selected;
use super::stage::ResponseRun;
use super::train::{Found, ResponseTraining, moved};
use crate::{Assembly, EngineError};
use rijke_inference::Parameter;
use rijke_numerics::{C64, Jet, Order};
use rijke_study::responses::ResponseStage;
use rijke_study::{Cause, STEP};
use std::collections::BTreeSet;

/// Movement of the parameters from fit to fit, in their standard deviations, at which the errors of what is
/// stated have settled: what is left out is of its square.
const STAYS: f64 = 0.05;
/// Most fits until they settle.
const FITS: usize = 50;
/// Nats of evidence by which another maximum is worth a word.
const BETTER: f64 = 1.0;
/// An error over whose standard deviation the answers bend by this share of their change is told.
const BENT: f64 = 0.1;

/// The causes of error of an operating point, and the loads there.
type Acting = (BTreeSet<Cause>, Vec<usize>);

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
        let (mut slopes, mut mixed) = (vec![Vec::new(); loads.len()], vec![Vec::new(); loads.len()]);
        for (causes, of_point) in self.acting(data)? {
            let known = |cause: &Cause| errors.causes.binary_search(cause).ok();
            let causes: Vec<(usize, &Cause)> = causes.iter().filter_map(|c| Some((known(c)?, c))).collect();
            let moved = |by: &[(&Cause, f64)]| self.beside(assembly, data, &errors, (by, &of_point), own);
            let mut all_above = Vec::with_capacity(causes.len());
            for (k, cause) in &causes {
                let [below, above] = [-STEP, STEP].map(|by| moved(&[(*cause, by)]));
                let (below, above) = (below?, above?);
                for ((load, below), above) in of_point.iter().zip(&below).zip(&above) {
                    let sides = below.iter().zip(above).zip(&here[*load]);
                    let slope =
                        |((below, above), here)| Slope::between([below, here, above], STEP, own.len());
                    slopes[*load].push((*k, sides.map(slope).collect()));
                }
                all_above.push(above);
            }
            for [a, b] in (0..causes.len()).flat_map(|b| (0..b).map(move |a| [a, b])) {
                let [(first, with), (second, there)] = [causes[a], causes[b]];
                let both = moved(&[(with, STEP), (there, STEP)])?;
                for (place, load) in of_point.iter().enumerate() {
                    let alone = [&all_above[a][place][..], &all_above[b][place][..]];
                    let of_load = mixed_between(&both[place], alone, &here[*load], STEP);
                    mixed[*load].push(([first, second], of_load));
                }
            }
        }
        errors.mixed = mixed;
        (errors.own, errors.slopes) = (own.to_vec(), slopes);
        Ok(Responses { loads, errors, own: responses.own, channels: responses.channels.clone() })
    }

    /// Those of every operating point of a stage.
    fn acting(&self, data: &Selected) -> Result<Vec<Acting>, EngineError> {
        let points: BTreeSet<usize> = data.points.iter().copied().collect();
        let of_point = |point: usize| {
            let loads = (0..data.points.len()).filter(|l| data.points[*l] == point).collect();
            Ok((causes_at(&self.study, point)?, loads))
        };
        points.into_iter().map(of_point).collect()
    }

    /// The answers of these loads where causes of error are larger by so many standard deviations.
    fn beside(
        &self,
        assembly: &Assembly,
        data: &Selected,
        errors: &Errors,
        (by, loads): (&[(&Cause, f64)], &[usize]),
        own: &[f64],
    ) -> Result<Vec<Vec<Jet>>, EngineError> {
        let larger = |c: &Cause| by.iter().find(|(cause, _)| *cause == c).map_or(0.0, |(_, by)| *by);
        let error = |c: &Cause| errors.value(c) + larger(c);
        let there = loads.iter().map(|load| self.load(assembly, data, *load, &error));
        clear(&there.collect::<Result<Vec<_>, _>>()?, own, Order::Value)
    }

    /// What is to be said of errors in which the answers bend: over the standard deviation that training
    /// `found` of one, the part that is not linear is [`BENT`] of the change, and larger than the noise of
    /// all numbers together.
    ///
    /// # Errors
    /// Those of the model that are not for one value of an error alone.
    pub(super) fn bent(
        &self,
        assembly: &Assembly,
        data: &Selected,
        at_last: &Responses<'_>,
        found: &Found,
        rest: Rest<'_>,
    ) -> Result<Vec<String>, EngineError> {
        let (own, errors) = (&found.fit.parameters[..at_last.own], &at_last.errors);
        let here = clear(&at_last.loads, own, Order::Value)?;
        let mut sums = vec![[0.0; 2]; errors.causes.len()];
        let all = self.acting(data)?;
        for (cause, loads) in all.iter().flat_map(|(causes, loads)| causes.iter().map(move |c| (c, loads))) {
            let Ok(k) = errors.causes.binary_search(cause) else { continue };
            let place = at_last.own + k;
            let sd = found.laplace.physical_covariance[(place, place)].sqrt();
            let side = |by: f64| self.beside(assembly, data, errors, (&[(cause, by)], loads), own);
            let (up, down) = match (side(sd), side(-sd)) {
                (Ok(up), Ok(down)) => (up, down),
                (Err(e), _) | (_, Err(e)) if !e.is_recoverable() => return Err(e),
                _ => {
                    sums[k] = [1.0, f64::INFINITY];
                    continue;
                }
            };
            for ((load, up), down) in loads.iter().zip(&up).zip(&down) {
                let (m, here) = (&data.measured[*load], &here[*load]);
                let count = here.len() / m.values.len().max(1);
                let size = |all: &mut dyn Iterator<Item = C64>| all.map(|z| z.norm_sqr()).sum::<f64>();
                // Of unknown sources the strength is that of the pressures.
                let level = size(&mut m.values.iter().copied()) / size(&mut here.iter().map(Jet::value));
                let level = if m.sources > 0 { level } else { 1.0 };
                for (i, ((u, d), h)) in up.iter().zip(down).zip(here).enumerate() {
                    let weight = level / (2.0 * rest.covariance_of(m, i / count, i / count));
                    let (u, d, h) = (u.value(), d.value(), h.value());
                    sums[k][0] += weight * (0.5 * (u - d)).norm_sqr();
                    sums[k][1] += weight * (0.5 * (u + d) - h).norm_sqr();
                }
            }
        }
        let told = |(p, [change, bend]): (Parameter, [f64; 2])| {
            let share = (bend / change).sqrt();
            (bend > 1.0 && share > BENT).then(|| {
                format!(
                    "{}: over its standard deviation the predictions deviate from a straight line by {:.0} % of their change: the posterior is no \
                     Gaussian, and standard deviations and evidence are approximate. Make this number an unknown of the rig, and write `checked = true`",
                    p.name,
                    100.0 * share
                )
            })
        };
        Ok(errors.parameters().into_iter().zip(sums).filter_map(told).collect())
    }
}

impl ResponseTraining<'_> {
    /// As [`ResponseTraining::with_errors`]. Where a stage that looks for no other maxima is left with
    /// residuals that are no small fault of the model, they are looked for, and a warning says so.
    ///
    /// # Errors
    /// As [`ResponseTraining::with_errors`].
    pub(super) fn of_a_row<'r>(
        &self,
        about: &dyn Fn(&[f64]) -> Result<Responses<'r>, EngineError>,
    ) -> Result<(Option<Responses<'r>>, Found), EngineError> {
        let first = self.with_errors(about);
        let poor = |found: &Found| {
            let rest = Rest { noise: &found.fit.noise, kernel: self.stage.misfit.as_ref().map(|m| m.kernel) };
            left(self.measured, found.heard.clone(), rest).share > POOR
        };
        if self.stage.checked || first.as_ref().is_ok_and(|(_, found)| !poor(found)) {
            return first;
        }
        let checked = ResponseStage { checked: true, ..self.stage.clone() };
        let again = ResponseTraining { stage: &checked, ..*self }.with_errors(about);
        let worth = |found: &Found| found.evidence.ln_marginal;
        match (first, again) {
            (Ok((_, one)), Ok((at_last, mut best))) if worth(&best) > worth(&one) + BETTER => {
                best.warnings.push(format!(
                    "the first search ended {:.0} nats lower, with residuals too large for a good model: other maxima were sought, and this one is better",
                    worth(&best) - worth(&one)
                ));
                Ok((at_last, best))
            }
            (Err(_), Ok(best)) => Ok(best),
            (first, _) => first,
        }
    }

    /// As [`ResponseTraining::found`], with the errors of what is stated taken where the fit ends: `about`
    /// are the responses with these errors about values of all parameters, and returned as they were last, if
    /// there are errors.
    ///
    /// # Errors
    /// As [`ResponseTraining::found`], those of `about`, and [`EngineError::Unsettled`] where the errors do
    /// not settle.
    pub(super) fn with_errors<'r>(
        &self,
        about: &dyn Fn(&[f64]) -> Result<Responses<'r>, EngineError>,
    ) -> Result<(Option<Responses<'r>>, Found), EngineError> {
        if self.responses.errors.is_none() {
            return Ok((None, self.found()?));
        }
        let quick = ResponseStage { checked: false, ..self.stage.clone() };
        // Without errors there need not be a fit.
        let mut before = ResponseTraining { stage: &quick, ..*self }.found().ok().map(|found| found.fit);
        let mut at = before.as_ref().map_or_else(|| self.middle(), |fit| fit.parameters.clone());
        let (mut stage, mut last, mut share) = (&quick, f64::INFINITY, 1.0_f64);
        for _ in 0..FITS {
            let responses = about(&at)?;
            let found = ResponseTraining { responses: &responses, stage, ..*self }.found_from(before)?;
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
                "the stated errors of factors or temperatures are so large that the fit does not settle: after {FITS} fits the parameters still \
                 move by {last:.2} standard deviations; make what is in error an unknown of the rig (`\"thickness + $off\"`)"
            ),
        })
    }
}
