//! Tests of the signal layer from outside the crate, on records made here from formulas.
#![allow(clippy::unwrap_used, clippy::print_stdout, clippy::panic, reason = "tests may stop and show tables")]

mod any;
mod beating;
mod blows;
mod bound;
mod calibrated;
mod chirping;
mod click;
mod clicking;
mod coarse;
mod compared;
mod drifting;
mod driven;
mod excess;
mod exchanged;
mod excited;
mod fading;
mod free;
mod hum;
mod lost;
mod naive;
mod ping;
mod pulses;
mod reasons;
mod ringing;
mod shapes;
mod short;
mod swept;
mod taken;
mod toned;
mod uncalibrated;
mod wandering;
