//! Observations with the state of the gas under which each was made.

use crate::{Conditions, Displaced, EngineError, Observed};
use rijke_numerics::words::rounded;
use rijke_study::plan::{Base, HeatedFlow, Selection};
use rijke_study::{
    Cause, GasReading, HeatedFit, ObservedModes, Point, PointState, RigAtPoint, STEP, Study, StudyProblem,
    heated_states, measured_states, read_readings, read_states,
};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// What is known of the temperature at every point, K: read with its records, or stated in the campaign.
pub(in crate::run) fn ambient_of_all(study: &Study, observations: &ObservedModes) -> Vec<Option<[f64; 2]>> {
    let of_the_file = matches!(study.plan.base, Base::Rig).then_some([study.rig.temperature, 0.0]);
    let points = study.campaign.points.iter().enumerate();
    points.map(|(k, point)| observations.ambient.get(&k).copied().or(point.ambient).or(of_the_file)).collect()
}

/// States of the gas by the place of their point, and what readings of thermometers say of the heat where a
/// part heats the gas.
type StatesAndHeat = (BTreeMap<usize, PointState>, Option<HeatedFit>);

/// The states that were inferred or read, by the place of their point; `measured` says whether readings must
/// be there.
pub(in crate::run) fn states(
    study: &Study,
    ambient: &[Option<[f64; 2]>],
    measured: bool,
) -> Result<BTreeMap<usize, PointState>, EngineError> {
    Ok(states_and_heat(study, ambient, measured)?.0)
}

/// As [`states`], with what readings say of the heat.
pub(in crate::run) fn states_and_heat(
    study: &Study,
    ambient: &[Option<[f64; 2]>],
    measured: bool,
) -> Result<StatesAndHeat, EngineError> {
    match &study.plan.base {
        Base::Ambient | Base::Rig => Ok(StatesAndHeat::default()),
        Base::HeatedFlow(flow) => heated(study, flow, ambient, measured),
        Base::Measured(plan) => {
            // Without readings the gas is ambient.
            let readings = readings_of(study, false)?;
            let layouts = layouts(study, ambient, &readings)?;
            let found = measured_states(&study.rig, &study.campaign, plan, &readings, ambient, &layouts);
            let states = found.map_err(|problem| EngineError::Readings { problem: Box::new(problem) })?;
            Ok((states.into_iter().enumerate().filter_map(|(k, state)| Some((k, state?))).collect(), None))
        }
        Base::States(_) => {
            let path = study.folder.join("base").join("states.json");
            // Cold points need none; a point that does is refused by [`conditions`].
            if !path.exists() {
                return Ok(StatesAndHeat::default());
            }
            let mut states = study.foreseen.clone();
            states.extend(read_states(&path, &study.rig)?);
            let place = |(id, state): (String, PointState)| Some((study.campaign.point(&id)?.0, state));
            Ok((states.into_iter().filter_map(place).collect(), None))
        }
    }
}

/// The readings of thermometers; none where there is no file of them, which `needed` refuses.
fn readings_of(study: &Study, needed: bool) -> Result<Vec<GasReading>, EngineError> {
    let read = |path: PathBuf| read_readings(&path, &study.campaign, &study.rig);
    Ok(study.readings(needed)?.map(read).transpose()?.unwrap_or_default())
}

/// The rig at every point whose temperature at the inlet is known: ambient, or as the first reading has it.
fn layouts(
    study: &Study,
    ambient: &[Option<[f64; 2]>],
    readings: &[GasReading],
) -> Result<Vec<Option<RigAtPoint>>, EngineError> {
    let layout = |(k, point): (usize, &Point)| {
        let fail = |source| EngineError::Rig { point: point.id.clone(), source: Box::new(source) };
        let read = readings.iter().filter(|r| r.point == k).min_by(|a, b| a.at.total_cmp(&b.at));
        let kelvin = read.map(|r| r.temperature).or(ambient[k].map(|t| t[0]));
        kelvin.map(|t| study.rig.at(point, t).map_err(fail)).transpose()
    };
    study.campaign.points.iter().enumerate().map(layout).collect()
}

/// The states of gas that a part heats, from the readings.
fn heated(
    study: &Study,
    flow: &HeatedFlow,
    ambient: &[Option<[f64; 2]>],
    measured: bool,
) -> Result<StatesAndHeat, EngineError> {
    // Before anything is measured the gas is as the priors have it.
    let readings = readings_of(study, measured)?;
    let layouts = layouts(study, ambient, &[])?;
    let found = heated_states(&study.rig, &study.campaign, flow, &readings, ambient, &layouts);
    let (states, fit) = found.map_err(|problem| EngineError::Readings { problem: Box::new(problem) })?;
    let states = states.into_iter().enumerate().filter_map(|(k, state)| Some((k, state?))).collect();
    Ok((states, (!readings.is_empty()).then_some(fit)))
}

/// Whether the state of the gas at a point must have been inferred, and was not.
pub(in crate::run) fn lacks_state(study: &Study, point: &Point, inferred: Option<&PointState>) -> bool {
    let due = |points: &Selection| points.holds(&study.campaign, point);
    inferred.is_none() && matches!(&study.plan.base, Base::States(points) if due(points))
}

/// The conditions of an operating point of a study, of which `inferred` may be known.
pub(in crate::run) fn conditions(
    study: &Study,
    point: &Point,
    inferred: Option<&PointState>,
    ambient: Option<[f64; 2]>,
) -> Result<Conditions, EngineError> {
    if lacks_state(study, point, inferred) {
        return Err(EngineError::NoState { point: point.id.clone() });
    }
    conditions_or_ambient(study, point, inferred, ambient)
}

/// As [`conditions`]; gas whose state must yet be inferred has the ambient temperature and rests.
pub(in crate::run) fn conditions_or_ambient(
    study: &Study,
    point: &Point,
    inferred: Option<&PointState>,
    ambient: Option<[f64; 2]>,
) -> Result<Conditions, EngineError> {
    let rig = &study.rig;
    let fail = |source| EngineError::Rig { point: point.id.clone(), source: Box::new(source) };
    if let (Base::HeatedFlow(heated), None, Some(_)) = (&study.plan.base, inferred, ambient) {
        let flow = study.campaign.factor(&heated.flow).map_or(f64::NAN, |k| point.factors[k]);
        let (key, value) = (heated.flow.clone(), format!("{} m^3/s", rounded(flow)));
        return Err(fail(StudyProblem::Value { key, value, need: "above zero where there is power" }));
    }
    if let (Base::Measured(_), None, Some(_)) = (&study.plan.base, inferred, ambient) {
        return Err(EngineError::NoReadings { point: point.id.clone() });
    }
    let ambient = match (inferred, ambient) {
        // What enters the rig is ambient gas.
        (Some(state), _) => [state.temperature[0], 0.0],
        (None, Some(ambient)) => ambient,
        (None, None) => return Err(EngineError::NoTemperature { point: point.id.clone() }),
    };
    let layout = rig.at(point, ambient[0]).map_err(fail)?;
    let base = match (inferred, &study.plan.base) {
        (Some(state), _) => state.clone().in_ducts(&layout),
        (None, Base::Rig) => PointState::of_the_rig(rig, &layout, point, ambient).map_err(fail)?,
        (None, _) => PointState::uniform(rig, layout.length, ambient[0], ambient[1], Cause::ambient(point))
            .in_ducts(&layout),
    };
    let base = base.checked(&point.id).map_err(fail)?;
    let uncertain = point.factor_sds.iter().zip(&point.factors).zip(&study.campaign.factors).enumerate();
    let uncertain = uncertain.filter(|(_, ((sd, value), _))| **sd > 0.0 && value.is_finite());
    let displaced = uncertain.map(|(k, ((sd, value), factor))| {
        let moved = |by: f64, state: Option<&PointState>| {
            let mut moved = Point { factor_sds: vec![0.0; point.factors.len()], ..point.clone() };
            moved.factors[k] += by * sd;
            conditions_or_ambient(study, &moved, state, Some(ambient)).map(Arc::new)
        };
        // Of gas that was inferred and follows the factor one small step is known.
        let followed = inferred.and_then(|s| s.moved.iter().find(|(factor, _)| *factor == k));
        let (name, near) = (factor.name.clone(), moved(STEP, followed.map_or(inferred, |(_, s)| Some(s)))?);
        let far = |by: &f64| match inferred.zip(followed) {
            Some((here, (_, near))) => moved(*by, Some(&here.beyond(near, by / STEP)?)).ok(),
            None => moved(*by, inferred).ok(),
        };
        let far: Option<Vec<_>> = Displaced::FAR.iter().map(far).collect();
        let far = far.and_then(|all| all.try_into().ok());
        let cause = match study.plan.common_errors.contains(&name) {
            true => Cause::of_all_points(&name),
            false => {
                Cause::Factor { name, installation: point.installation.clone(), level: value.to_string() }
            }
        };
        Ok(Displaced { cause, relative: sd / value.abs(), near, far })
    });
    let displaced = displaced.collect::<Result<Vec<_>, EngineError>>()?;
    Ok(Conditions { id: point.id.clone(), point: point.clone(), layout, base, displaced })
}

/// The conditions of the operating point of number `k`, from what the campaign and the rig say.
pub(crate) fn conditions_at(study: &Study, k: usize) -> Result<Conditions, EngineError> {
    conditions_of(study, &study.campaign.points[k])
}

/// As [`conditions_at`], of a point that may lie beside one of the campaign.
pub(crate) fn conditions_of(study: &Study, point: &Point) -> Result<Conditions, EngineError> {
    let of_the_file = Some([study.rig.temperature, 0.0]);
    conditions_or_ambient(study, point, None, point.ambient.or(of_the_file))
}

/// A point whose factors, which are known to a standard deviation, are off by so many of these by each cause
/// of error of its conditions.
pub(crate) fn with_factors_moved(
    study: &Study,
    point: &Point,
    conditions: &Conditions,
    error: &dyn Fn(&Cause) -> f64,
) -> Point {
    let mut moved = point.clone();
    for Displaced { cause, .. } in &conditions.displaced {
        let Cause::Factor { name, .. } = cause else { continue };
        if let Some(k) = study.campaign.factor(name) {
            moved.factors[k] += error(cause) * point.factor_sds[k];
        }
    }
    moved
}

/// The observed points that a stage means but that have no state of their gas, though others have: they are
/// left out.
pub(in crate::run) fn left_out(
    study: &Study,
    observations: &ObservedModes,
    states: &BTreeMap<usize, PointState>,
) -> Vec<String> {
    let mut ids: Vec<String> = Vec::new();
    for mode in &observations.modes {
        let point = &study.campaign.points[mode.point];
        let wanted = study.plan.stages.iter().any(|stage| stage.points.holds(&study.campaign, point));
        if wanted && lacks_state(study, point, states.get(&mode.point)) && !ids.contains(&point.id) {
            ids.push(point.id.clone());
        }
    }
    ids
}

/// Those that a selection means.
pub(in crate::run) fn selected(study: &Study, all: &[Observed], selection: &Selection) -> Vec<Observed> {
    let meant = |o: &&Observed| selection.holds(&study.campaign, &o.conditions.point);
    all.iter().filter(meant).cloned().collect()
}
