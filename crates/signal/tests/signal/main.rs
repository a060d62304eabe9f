//! Tests of the signal layer from outside the crate, on records made here from formulas.
mod ping;
mod ringing;
