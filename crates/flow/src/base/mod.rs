//! Base states: what acoustics takes from the slow flow, per operating point and on disk, each with its
//! uncertainty.
//!
//! Knows neither the equations of the tube nor how a state was inferred; `profiles` makes states of what was
//! measured directly.

pub(crate) mod laws;
pub(crate) mod profiles;
pub(crate) mod state;
pub(crate) mod states;
pub(crate) mod table;
