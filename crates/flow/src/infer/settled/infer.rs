//! From the mean readings of a campaign to base states, all places of the heater in one fit or each by
//! itself.

use super::observed::runs;
use super::{JointFit, Readings, SettledRun};
use crate::apparatus::observed::TubeObservations;
use crate::error::FlowError;
use crate::infer::report::{NamedStates, RunReport};
use crate::tube::closures::Closures;
use crate::tube::pipe::Pipe;
use rayon::prelude::*;
use rijke_numerics::InOrder;

/// Tubes with what was read in them, one for each place of the heater at which there was power.
///
/// # Errors
/// Those of [`Pipe::new`] and of the readings.
pub fn heated(
    observations: &TubeObservations,
    readings: &Readings,
    closures: &Closures,
) -> Result<Vec<(Pipe, SettledRun)>, FlowError> {
    runs(observations, readings, &|at| Pipe::new(&observations.rig, closures, at, 1))
}

/// What is inferred of all `runs`, and their base states. `separate`: each place of the heater is a fit of
/// its own, whose errors no other place shares. `done` hears how many places are ready.
///
/// # Errors
/// Those of the fit.
pub fn infer(
    runs: &[(Pipe, SettledRun)],
    separate: bool,
    done: &(dyn Fn(u64) + Sync),
) -> Result<(Vec<RunReport>, NamedStates), FlowError> {
    let groups: Vec<&[(Pipe, SettledRun)]> = if separate { runs.chunks(1).collect() } else { vec![runs] };
    let fit = |group: &&[(Pipe, SettledRun)]| {
        let report = JointFit::new(group)?.report();
        done(group.len() as u64);
        report
    };
    let fits = groups.par_iter().map(fit).in_order::<Result<Vec<_>, FlowError>>()?;
    let (mut reports, mut states) = (Vec::new(), NamedStates::new());
    for (n, (run, mut named)) in fits.into_iter().enumerate() {
        if separate {
            // Causes are shared by name; places that were fitted apart share none.
            let errors = named.iter_mut().flat_map(|(_, state)| &mut state.errors);
            errors.for_each(|e| e.cause = format!("place {}: {}", n + 1, e.cause));
        }
        reports.extend(run);
        states.extend(named);
    }
    Ok((reports, states))
}
