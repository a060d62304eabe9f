//! The inferred flow as base states of a study: `states.json`.

use rijke_flow::{BaseStates, ErrorForLaws, StateForLaws, TubeObservations};
use rijke_study::{ErrorRecord, StateRecord, StatesFile};

/// What the flow hands to the study.
pub(super) fn states(states: &BaseStates, observations: &TubeObservations) -> StatesFile {
    let error = |e: ErrorForLaws| {
        let ErrorForLaws { cause, mass_flow, numbers, temperature } = e;
        ErrorRecord { cause, mass_flow, numbers, temperature }
    };
    let record = |state: StateForLaws| {
        let StateForLaws { mass_flow, numbers, places, temperature, kinks, errors } = state;
        let errors = errors.into_iter().map(error).collect();
        StateRecord { mass_flow, numbers, places, temperature, kinks, errors }
    };
    let points = states.for_laws(observations).into_iter();
    StatesFile { points: points.map(|(id, state)| (id, record(state))).collect() }
}
