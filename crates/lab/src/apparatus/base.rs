//! The slow flow that is really there: the model of crate `flow` on a finer grid, with closures that a candidate does
//! not have.

use crate::truth::{LabError, Truth};
use rijke_flow::{BaseState, Pipe};
use rijke_rig::{OperatingPoint, Rig};

/// How much finer than the candidate's grid: errors of the grid are then a tenth of what a candidate makes.
const REFINEMENT: u32 = 4;

/// Temperature and velocity along the tube at an operating point, ambient `temperature` (K), settled: what is really there.
///
/// # Errors
/// [`LabError::Flow`] where the flow does not settle.
pub fn base_state(
    rig: &Rig,
    truth: &Truth,
    point: &OperatingPoint,
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
