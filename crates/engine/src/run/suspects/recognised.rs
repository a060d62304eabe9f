//! Whether the measured modes are modes of the rig at all, before the models compete.

use super::super::combined::assembly_of;
use super::super::course::{Run, Trusted};
use super::super::points::inputs::selected;
use super::matching::check_modes;
use crate::EngineError;
use crate::rows::Row;
use rijke_study::{ObservedModes, Study};

/// Refuses a first stage of which no model can be fitted, as training does. Models are trained only where
/// none has the measured modes in the middle of its priors.
///
/// # Errors
/// [`EngineError::NoWinner`].
pub fn recognised(study: &Study, observations: &ObservedModes) -> Result<(), EngineError> {
    let Some(stage) = study.plan.stages.first().filter(|stage| stage.on.is_empty()) else { return Ok(()) };
    // What stops a run before its first stage is said elsewhere.
    let Ok(mut run) = Run::new(study.clone(), observations, Trusted::Laplace) else { return Ok(()) };
    let points = selected(&run.study, &run.observed, &stage.points);
    let strange = |row: &Row| {
        let assembly = assembly_of(study, &row.choice, &stage.hold);
        assembly.and_then(|assembly| check_modes(&assembly, &points, &[])).is_err()
    };
    if points.is_empty() || !run.rows(stage).iter().all(strange) {
        return Ok(());
    }
    match run.next_stage() {
        Err(refused @ EngineError::NoWinner { .. }) => Err(refused),
        _ => Ok(()),
    }
}
