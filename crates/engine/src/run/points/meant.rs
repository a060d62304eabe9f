//! Observations under their conditions, and which mode each is of.

use super::super::combined::first_model;
use super::followed::Followed;
use super::inputs::{conditions, lacks_state};
use crate::{Assembly, Conditions, EngineError, Observed, PointModel};
use rijke_numerics::C64;
use rijke_study::{ObservedModes, PointState, Study};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Where the root of a mode is sought whose growth rate was not measured, 1/s.
pub(in crate::run) const GROWTH_RATE: f64 = -10.0;
/// Stands where no frequency was measured until it is known which mode is meant.
const UNKNOWN: C64 = C64::new(GROWTH_RATE, 0.0);

/// All observations of a study, in the order of its table. A mode of which only the growth rate was measured
/// is that of its label at the nearest point where it has a frequency, or else the only one that the rig has
/// in the region of the search.
pub(in crate::run) fn observed(
    study: &Study,
    observations: &ObservedModes,
    states: &BTreeMap<usize, PointState>,
    ambient: &[Option<[f64; 2]>],
) -> Result<Vec<Observed>, EngineError> {
    let mut known: BTreeMap<usize, Arc<Conditions>> = BTreeMap::new();
    let mut all = Vec::new();
    for mode in &observations.modes {
        let point = &study.campaign.points[mode.point];
        let wanted = study.plan.stages.iter().any(|stage| stage.points.holds(&study.campaign, point));
        // One point of many whose flow could not be inferred does not end a campaign; without any state there
        // is nothing to stand on.
        if lacks_state(study, point, states.get(&mode.point)) && (!wanted || !states.is_empty()) {
            continue;
        }
        let conditions = match known.get(&mode.point) {
            Some(conditions) => conditions.clone(),
            None => {
                let new = conditions(study, point, states.get(&mode.point), ambient[mode.point])?;
                known.entry(mode.point).or_insert_with(|| Arc::new(new)).clone()
            }
        };
        let near = mode.near(GROWTH_RATE).unwrap_or(UNKNOWN);
        all.push(Observed { conditions, mode: mode.clone(), near });
    }
    if all.iter().all(|o| o.near != UNKNOWN) {
        return Ok(all);
    }
    let heard: Vec<Observed> = all.iter().filter(|o| o.near != UNKNOWN).cloned().collect();
    let everywhere: Vec<String> = heard.iter().map(|o| o.conditions.id.clone()).collect();
    let followed = Followed::of(study, &heard, &everywhere);
    let model = first_model(study)?;
    for observed in all.iter_mut().filter(|o| o.near == UNKNOWN) {
        let growth = observed.mode.growth_rate.unwrap_or(GROWTH_RATE);
        let omega = match followed.near(&observed.mode.label, &observed.conditions) {
            Some(near) => near.im,
            None => only_mode(&model, &observed.conditions)?.im,
        };
        observed.near = C64::new(growth, omega);
    }
    Ok(all)
}

/// The mode of the rig in the region of the search, if it has one alone.
fn only_mode((assembly, values): &(Assembly, Vec<f64>), conditions: &Conditions) -> Result<C64, EngineError> {
    let modes = PointModel::new(assembly, conditions, &[])?.modes(values)?;
    match modes.as_slice() {
        [one] => Ok(*one),
        _ => Err(EngineError::NoFrequency { point: conditions.id.clone(), modes: modes.len() }),
    }
}
