//! Tests of the signal layer from outside the crate, on records made here from formulas.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "tests may stop and show tables")]

mod click;
mod clicking;
mod ping;
mod ringing;
