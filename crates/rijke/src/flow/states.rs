//! The inferred flow as base states of a study: `states.json`.

use rijke_flow::BaseStates;
use rijke_rig::Observations;
use rijke_study::{ErrorRecord, StateRecord, StatesFile};
use std::collections::BTreeMap;

/// Name of the velocity of the gas that approaches the heater, as `[base.numbers]` of a study declares it.
const VELOCITY: &str = "U_h";

/// The states of the points with power, or on a ramp; else the gas is at rest, as any study knows.
pub(super) fn states(states: &BaseStates, observations: &Observations) -> StatesFile {
    let rig = &observations.rig;
    let area = rig.tube.area();
    let number = |value: f64| BTreeMap::from([(VELOCITY.to_owned(), value)]);
    let ramped = |id: &str| observations.ramps.iter().any(|ramp| ramp.time_of(id).is_some());
    let powered = observations.points.iter().map(|p| &p.point).filter(|p| p.power > 0.0 || ramped(&p.id));
    let record = |point: &rijke_rig::OperatingPoint| {
        let state = states.points.get(&point.id)?;
        let half = 0.5 * rig.plates.length();
        let error = |e: &rijke_flow::ErrorComponent| ErrorRecord {
            cause: e.cause.clone(),
            mass_flow: e.mass_flux * area,
            numbers: number(e.heater_velocity),
            temperature: e.temperature.clone(),
        };
        let state = StateRecord {
            mass_flow: state.mass_flux * area,
            numbers: number(state.heater_velocity),
            places: state.places.clone(),
            temperature: state.temperature.clone(),
            // Between the faces of the heater the gas becomes hot.
            kinks: point.position.map(|x| [x - half, x + half]).into_iter().collect(),
            errors: state.errors.iter().map(error).collect(),
        };
        Some((point.id.clone(), state))
    };
    StatesFile { points: powered.filter_map(record).collect() }
}
