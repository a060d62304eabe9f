//! Observations with the state of the gas under which each was made.

use crate::{Conditions, EngineError, Observed};
use rijke_study::plan::{Base, Selection};
use rijke_study::{BaseState, Cause, Observations, Point, Sharing, Study, read_states};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Where the root of a mode is sought whose growth rate was not measured, 1/s.
const GROWTH_RATE: f64 = -10.0;

/// The conditions of an operating point of a study.
pub(super) fn conditions(
    study: &Study,
    states: &BTreeMap<String, BaseState>,
    point: &Point,
    read: Option<[f64; 2]>,
) -> Result<Conditions, EngineError> {
    let rig = &study.rig;
    let fail = |source| EngineError::Rig { point: point.id.clone(), source: Box::new(source) };
    let inferred = states.get(&point.id);
    let ambient = match (inferred, read.or(point.ambient)) {
        // What enters the rig is ambient gas.
        (Some(state), _) => [state.temperature[0], 0.0],
        (None, Some(ambient)) => ambient,
        (None, None) if study.plan.base == Base::Rig => [rig.temperature, 0.0],
        (None, None) => return Err(EngineError::NoTemperature { point: point.id.clone() }),
    };
    let layout = rig.at(point, ambient[0]).map_err(fail)?;
    let base = match (inferred, &study.plan.base) {
        (Some(state), _) => state.clone(),
        (None, Base::Rig) => BaseState::of_the_rig(rig, &layout, point, ambient),
        (None, _) => {
            let cause = Cause::Ambient(Sharing::Point(point.id.clone()));
            BaseState::uniform(rig, layout.length, ambient[0], ambient[1], cause)
        }
    };
    let base = base.checked(&point.id).map_err(fail)?;
    Ok(Conditions { id: point.id.clone(), point: point.clone(), layout, base })
}

/// All observations of a study, in the order of its table.
pub(super) fn observed(study: &Study, observations: &Observations) -> Result<Vec<Observed>, EngineError> {
    let states = match study.plan.base {
        Base::States => read_states(&study.folder.join("base").join("states.json"), &study.rig)?,
        _ => BTreeMap::new(),
    };
    let mut known: BTreeMap<usize, Arc<Conditions>> = BTreeMap::new();
    let mut all = Vec::new();
    for mode in &observations.modes {
        let point = &study.campaign.points[mode.point];
        let conditions = match known.get(&mode.point) {
            Some(conditions) => conditions.clone(),
            None => {
                let new = Arc::new(conditions(
                    study,
                    &states,
                    point,
                    observations.ambient.get(&mode.point).copied(),
                )?);
                known.insert(mode.point, new.clone());
                new
            }
        };
        let near =
            mode.near(GROWTH_RATE).ok_or_else(|| EngineError::NoFrequency { point: point.id.clone() })?;
        all.push(Observed { conditions, mode: mode.clone(), near });
    }
    Ok(all)
}

/// Those that a selection means.
pub(super) fn selected(study: &Study, all: &[Observed], selection: &Selection) -> Vec<Observed> {
    let meant = |o: &&Observed| selection.holds(&study.campaign, &o.conditions.point);
    all.iter().filter(meant).take(selection.first.unwrap_or(usize::MAX)).cloned().collect()
}
