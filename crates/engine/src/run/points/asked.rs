//! Predictions of a saved model at any values of the factors, measured or not.

use super::super::combined::{assembly_of, first_model};
use super::super::stages::average::OpenModel;
use super::followed::Sought;
use super::inputs::{ambient_of_all, conditions, states, with_factors_moved};
use super::predicted::{Forecast, averaged};
use super::ready::{Known, Ready};
use crate::{BeyondTable, EngineError, Misfit, PointModel, PointPrediction, SavedModel, Spectrum};
use rayon::prelude::*;
use rijke_inference::{Parameter, normal_cdf};
use rijke_network::Region;
use rijke_numerics::{C64, InOrder};
use rijke_study::{Cause, ObservedModes, Point, Study};
use std::collections::BTreeMap;

/// A point of which a model cannot say anything.
#[derive(Debug)]
pub struct Unpredicted {
    /// Name of the point.
    pub point: String,
    /// Why not.
    pub why: EngineError,
}

/// Every mode of a model at a point of the campaign: of the saved one at its mean, else of the first row of
/// the last stage at the centre of its priors. Also the places of devices, m, and the temperature at x = 0,
/// K, as it is stated and as it counts: errors of the base state that points share have the values that the
/// training inferred, as in predictions.
///
/// # Errors
/// [`EngineError::NoState`], and those of the model.
pub fn modes_at(
    study: &Study,
    observations: Option<&ObservedModes>,
    model: Option<&SavedModel>,
    point: usize,
    limits_hz: [Option<f64>; 2],
) -> Result<(Region, Spectrum, Vec<f64>, [f64; 2]), EngineError> {
    let point_of = &study.campaign.points[point];
    let mut ambient = match observations {
        Some(observations) => ambient_of_all(study, observations),
        None => study.campaign.points.iter().map(|p| p.ambient).collect(),
    };
    ambient.iter_mut().for_each(|t| *t = t.or(Some([study.rig.temperature, 0.0])));
    let states = states(study, &ambient, observations.is_some())?;
    let conditions_of = |point_of: &Point| conditions(study, point_of, states.get(&point), ambient[point]);
    let mut conditions = conditions_of(point_of)?;
    let stated = conditions.base.temperature[0];
    let (assembly, values) = match model {
        Some(model) => {
            let assembly = assembly_of(study, &model.candidates, &model.hold)?;
            let posterior = model.posterior()?;
            if !conditions.displaced.is_empty() {
                let error = |cause: &Cause| posterior.error_of(cause).map_or(0.0, |[error, _]| error);
                conditions = conditions_of(&with_factors_moved(study, point_of, &conditions, &error))?;
            }
            conditions.base = posterior.as_inferred(&conditions.base);
            let known = posterior.gaussian;
            let value = |p: &Parameter| {
                known.names.iter().position(|n| *n == p.name).map_or(f64::NAN, |k| known.mean[k])
            };
            let values: Vec<f64> = assembly.parameters().iter().map(value).collect();
            (assembly, values)
        }
        None => first_model(study)?,
    };
    let (region, spectrum) = PointModel::new(&assembly, &conditions, &[])?.spectrum(&values, limits_hz)?;
    let effects = assembly.candidates().iter().flat_map(|c| &c.effects);
    let places = effects.filter(|e| !e.place.is_along() && !e.place.is_end());
    let mut devices: Vec<f64> =
        places.flat_map(|e| conditions.layout.places(&e.place)).map(|(x, _)| x).collect();
    devices.sort_by(f64::total_cmp);
    devices.dedup();
    let temperature = [stated, conditions.base.temperature[0]];
    Ok((region, spectrum, devices, temperature))
}

/// What the saved model says of points of the campaign, by their places: of every mode that it was trained
/// on; averaged with the models `open` beside it, if there are any.
///
/// # Errors
/// Those of the saved models and of the files; a point that cannot be predicted is one of the second list.
pub fn forecast(
    study: &Study,
    observations: &ObservedModes,
    model: &SavedModel,
    open: &[OpenModel],
    points: &[usize],
) -> Result<(Vec<Forecast>, Vec<Unpredicted>), EngineError> {
    let known = Known::of(study, observations)?;
    let asked = Asked::of(&known, model)?;
    // A point that is asked for twice is one.
    let once = |(k, place): &(usize, &usize)| !points[..*k].contains(*place);
    let points: Vec<usize> = points.iter().enumerate().filter(once).map(|(_, place)| *place).collect();
    let points = points.as_slice();
    let (sought, lost) = asked.sought(points);
    let (mut forecasts, mut failures) = asked.forecasts(&sought);
    failures.extend(lost);
    let other = |k: &usize| Some((study.campaign.points[*k].id.clone(), asked.other(*k, &forecasts)?));
    let others: BTreeMap<String, _> = points.par_iter().filter_map(other).collect();
    for f in &mut forecasts {
        if let Some((other, beyond)) = others.get(&f.point) {
            (f.other, f.beyond[1]) = (Some(*other), beyond.clone());
        }
    }
    let of = |o: &OpenModel| Ok((o.odds, Asked::of(&known, &o.model)?.forecasts(&sought).0));
    let open: Vec<(f64, Vec<Forecast>)> = open.par_iter().map(of).in_order::<Result<_, EngineError>>()?;
    if !open.is_empty() {
        forecasts.iter_mut().for_each(|own| own.averaged = averaged(own, &open));
    }
    Ok((forecasts, failures))
}

/// A saved model that is asked to predict.
struct Asked<'a> {
    ready: Ready<'a>,
    misfit: Misfit,
    /// Misfit of the growth rate, without the errors of a measurement, 1/s.
    own_error: f64,
}

impl<'a> Asked<'a> {
    fn of(known: &'a Known<'a>, model: &'a SavedModel) -> Result<Self, EngineError> {
        let ready = Ready::of(known, model)?;
        let noise = &ready.posterior.noise;
        Ok(Self {
            misfit: Misfit::of_a_new_measurement(noise, &known.trained(model), model.measured),
            own_error: Misfit::of_growth(noise),
            ready,
        })
    }

    /// The modes at these points, and the points that cannot have any.
    fn sought(&self, points: &[usize]) -> (Vec<(usize, Sought)>, Vec<Unpredicted>) {
        let of = |k: &usize| {
            self.ready.followed.sought(&self.ready.assembly, self.ready.values(), &self.ready.conditions(*k)?)
        };
        let found: Vec<_> = points.par_iter().map(of).collect();
        let (mut all, mut lost) = (Vec::new(), Vec::new());
        for (k, found) in points.iter().zip(found) {
            match found {
                Ok(modes) => all.extend(modes.into_iter().map(|mode| (*k, mode))),
                Err(why) => {
                    lost.push(Unpredicted { point: self.ready.id(*k).clone(), why });
                }
            }
        }
        (all, lost)
    }

    /// Of these modes, without the others.
    fn forecasts(&self, sought: &[(usize, Sought)]) -> (Vec<Forecast>, Vec<Unpredicted>) {
        let found: Vec<_> = sought.par_iter().map(|(k, mode)| self.one(*k, mode)).collect();
        let (mut forecasts, mut failures) = (Vec::new(), Vec::new());
        for ((k, ..), found) in sought.iter().zip(found) {
            let apart = |own: Forecast| match forecasts.iter().find(|f: &&Forecast| own.is_of_the_mode_of(f))
            {
                Some(other) => Err(EngineError::ModesMet {
                    point: own.point,
                    first: other.mode.clone(),
                    second: own.mode,
                    hertz: own.angular_frequency[0] / std::f64::consts::TAU,
                }),
                None => Ok(own),
            };
            match found.and_then(apart) {
                Ok(forecast) => forecasts.push(forecast),
                Err(why) => {
                    let point = self.ready.id(*k).clone();
                    failures.push(Unpredicted { point, why });
                }
            }
        }
        // Of modes that met, neither label is known to be the right one.
        let met = |u: &Unpredicted, f: &Forecast| match &u.why {
            EngineError::ModesMet { first, .. } => u.point == f.point && *first == f.mode,
            _ => false,
        };
        forecasts.retain(|f| !failures.iter().any(|u| met(u, f)));
        (forecasts, failures)
    }

    fn one(&self, k: usize, Sought { label, near, lost }: &Sought) -> Result<Forecast, EngineError> {
        let conditions = self.ready.conditions(k)?;
        let microphones = &self.ready.known.study.rig.microphones;
        let heard = Some(microphones.reference).filter(|_| !microphones.at.is_empty());
        let law = self.ready.model.law.as_ref();
        let p: PointPrediction =
            self.ready.posterior.predict(&self.ready.assembly, &conditions, heard.as_slice(), *near, law)?;
        let number = |k: usize| [p.values[k], p.sd(k, &self.misfit), p.sd(k, &Misfit::default())];
        let (growth_rate, point) = (number(0), &self.ready.known.study.campaign.points[k]);
        if growth_rate.iter().chain(&number(1)).any(|v| !v.is_finite()) {
            return Err(EngineError::Damaged { stage: self.ready.model.stage.clone() });
        }
        let stability_sd = growth_rate[2].hypot(self.own_error);
        let s = C64::new(p.values[0], p.values[1]);
        let beyond = match self.ready.assembly.has_tables() {
            true => PointModel::new(&self.ready.assembly, &conditions, &[])?
                .beyond_a_table(self.ready.values(), s),
            false => None,
        };
        Ok(Forecast {
            point: point.id.clone(),
            mode: label.clone(),
            lost: *lost,
            factors: point.factors.iter().map(|v| Some(*v).filter(|v| v.is_finite())).collect(),
            growth_rate,
            angular_frequency: number(1),
            stability_sd,
            unstable: normal_cdf(growth_rate[0] / stability_sd),
            averaged: None,
            other: None,
            beyond: [beyond, None],
        })
    }

    /// The mode at a point that grows fastest of those that are not among `forecasts`: growth rate, 1/s, and
    /// frequency, Hz.
    fn other(&self, k: usize, forecasts: &[Forecast]) -> Option<([f64; 2], Option<BeyondTable>)> {
        let id = self.ready.id(k);
        let here = forecasts.iter().filter(|f| f.point == *id);
        let predicted = here.map(|f| C64::new(f.growth_rate[0], f.angular_frequency[0]));
        let conditions = self.ready.conditions(k).ok()?;
        let model = PointModel::new(&self.ready.assembly, &conditions, &[]).ok()?;
        let mut modes = model.modes(self.ready.values()).ok()?;
        // Predictions count the errors of base states that were inferred along, so that the same mode lies a
        // little apart.
        for predicted in predicted {
            let distance = |s: &C64| (s - predicted).norm();
            let nearest =
                (0..modes.len()).min_by(|a, b| distance(&modes[*a]).total_cmp(&distance(&modes[*b])));
            if let Some(k) = nearest.filter(|k| distance(&modes[*k]) < SAME_MODE * predicted.norm()) {
                modes.remove(k);
            }
        }
        let other = *modes.iter().max_by(|a, b| a.re.total_cmp(&b.re))?;
        let beyond = model.beyond_a_table(self.ready.values(), other);
        Some(([other.re, other.im / std::f64::consts::TAU], beyond))
    }
}

/// Two eigenvalues that lie closer, relative to their size, may be one.
const SAME_MODE: f64 = 0.05;
