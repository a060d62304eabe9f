//! The slow flow that is really there: the model of crate `flow` on a finer grid, with closures that a
//! candidate does not have.

use crate::truth::{LabError, Truth};
use rijke_flow::{BaseState, Pipe, Ramp, TubePoint, TubeRig, Unknowns};

/// How much finer than the candidate's grid: errors of the grid are then a tenth of what a candidate makes.
const REFINEMENT: u32 = 4;
/// Longest step of a run after a change of power, s: a third of a candidate's, so that the error of its steps
/// is a ninth.
const STEP: f64 = 5.0;

/// Temperature and velocity along the tube at an operating point, ambient `temperature` (K), settled: what is
/// really there.
///
/// # Errors
/// [`LabError::Flow`] where the flow does not settle.
pub fn base_state(
    rig: &TubeRig,
    truth: &Truth,
    point: &TubePoint,
    temperature: f64,
) -> Result<BaseState, LabError> {
    let failed = |cause| LabError::Flow { point: point.id.clone(), cause };
    match point.position {
        Some(position) if point.power > 0.0 => {
            let pipe = Pipe::new(rig, &truth.flow.closures, position, REFINEMENT).map_err(failed)?;
            let steady = pipe.steady(&truth.flow.parameters, point.power, temperature).map_err(failed)?;
            Ok(steady.base_state(&pipe))
        }
        _ => BaseState::uniform(&rig.gas, rig.pressure, rig.tube.length, temperature, 0.0).map_err(failed),
    }
}

/// The same at the time at which `point` was measured in the run `ramp`.
///
/// # Errors
/// [`LabError::Flow`] where there is no flow, or no such point in the run.
pub(crate) fn moving_state(
    rig: &TubeRig,
    truth: &Truth,
    point: &TubePoint,
    temperature: f64,
    ramp: &Ramp,
) -> Result<BaseState, LabError> {
    let failed = |cause| LabError::Flow { point: point.id.clone(), cause };
    let place = point.position.unwrap_or(f64::NAN);
    let pipe = Pipe::new(rig, &truth.flow.closures, place, REFINEMENT).map_err(failed)?;
    let unknowns = Unknowns::known(&truth.flow.parameters, &truth.flow.closures);
    let times: Vec<f64> = ramp.time_of(&point.id).into_iter().collect();
    let gas = pipe.gas_along(ramp, &unknowns, temperature, &times, STEP).map_err(failed)?;
    gas.first().map_or_else(|| base_state(rig, truth, point, temperature), |gas| Ok(pipe.base_state(gas)))
}
