//! Base states as laws of acoustics take them: with the mass flow, named numbers, and where the gas becomes
//! hot.

use super::state::{BaseState, ErrorComponent};
use super::states::BaseStates;
use crate::apparatus::observed::TubeObservations;
use crate::apparatus::point::TubePoint;
use rijke_rig::{ErrorRecord, StateRecord, StatesFile};
use std::collections::BTreeMap;

/// Name of the velocity of the gas that approaches the heater, as laws know it.
const VELOCITY: &str = "U_h";

impl BaseStates {
    /// The states of the points with power, or on a ramp; else the gas is at rest, as any study knows.
    #[must_use]
    pub fn for_laws(&self, observations: &TubeObservations) -> StatesFile {
        let ramped = |id: &str| observations.ramps.iter().any(|ramp| ramp.time_of(id).is_some());
        let powered = observations.points.iter().map(|p| &p.point);
        let powered = powered.filter(|p| p.power > 0.0 || ramped(&p.id));
        let (area, half) = (observations.rig.tube.area(), 0.5 * observations.rig.plates.length());
        let of = |point: &TubePoint| {
            let state = self.points.get(&point.id)?;
            Some((point.id.clone(), state.for_laws(area, half, point.position)))
        };
        StatesFile { points: powered.filter_map(of).collect() }
    }
}

impl BaseState {
    /// In a tube of this area (m^2), with the heater of half this length (m) at `at`.
    fn for_laws(&self, area: f64, half: f64, at: Option<f64>) -> StateRecord {
        let numbers = |velocity: f64| BTreeMap::from([(VELOCITY.to_owned(), velocity)]);
        let error = |e: &ErrorComponent| ErrorRecord {
            cause: e.cause.clone(),
            mass_flow: e.mass_flux * area,
            numbers: numbers(e.heater_velocity),
            temperature: e.temperature.clone(),
        };
        StateRecord {
            mass_flow: self.mass_flux * area,
            numbers: numbers(self.heater_velocity),
            places: self.places.clone(),
            temperature: self.temperature.clone(),
            // Between the faces of the heater the gas becomes hot.
            kinks: at.map(|x| [x - half, x + half]).into_iter().collect(),
            errors: self.errors.iter().map(error).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rijke_rig::Gas;

    #[test]
    fn exact_fluxes_become_flows_and_the_hot_zone_is_that_of_the_heater() {
        let mut state = BaseState::uniform(&Gas::air(), 101_325.0, 1.0, 300.0, 0.1).unwrap();
        (state.mass_flux, state.heater_velocity) = (0.6, 0.5);
        let found = state.for_laws(2e-3, 0.02, Some(0.25));
        assert_eq!((found.mass_flow, found.numbers["U_h"]), (1.2e-3, 0.5));
        assert!((found.kinks[0][0] - 0.23).abs() < 1e-15 && (found.kinks[0][1] - 0.27).abs() < 1e-15);
        assert_eq!(found.errors.len(), state.errors.len());
        assert!(state.for_laws(2e-3, 0.02, None).kinks.is_empty());
    }
}
