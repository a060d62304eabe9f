//! The base state of a cold operating point.

use crate::{Conditions, ModelError};
use rijke_flow::BaseState;
use rijke_rig::{PointObservations, Rig};

/// Gas at rest at the ambient temperature of the day: exact without power, where nothing drives a flow.
///
/// # Errors
/// [`ModelError::Flow`] for a temperature that is not positive.
pub fn ambient_state(rig: &Rig, observed: &PointObservations) -> Result<Conditions, ModelError> {
    let (ambient, sd) = (observed.ambient.ambient_temperature, observed.ambient.ambient_temperature_sd);
    let base = BaseState::uniform(&rig.gas, rig.pressure, rig.tube.length, ambient, sd)
        .map_err(|source| ModelError::Flow { point: observed.point.id.clone(), source })?;
    Ok(Conditions { point: observed.point.clone(), base, ambient })
}
