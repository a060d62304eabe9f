//! The tube: the equations of the slow flow in a heated tube with a conducting wall, and their solution,
//! steady and in time.
//!
//! From the bottom: `air`, `closures` and `convection` are laws, `pipe` cuts the tube into cells, `march`
//! takes the gas through them, `draught` finds the mass flow, `wall` closes the balance; `steady` and
//! `transient` solve, `ramp` takes a run through its log, `arrival` says what a click sees. Knows nothing of
//! measurements.

pub(crate) mod air;
mod arrival;
mod band;
pub(crate) mod closures;
mod convection;
pub(crate) mod draught;
pub(crate) mod march;
pub(crate) mod parameters;
pub(crate) mod pipe;
mod ramp;
pub(crate) mod steady;
pub(crate) mod transient;
pub(crate) mod wall;

#[cfg(test)]
mod exact;
