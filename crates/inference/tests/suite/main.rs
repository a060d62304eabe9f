//! One test binary; a module per subject.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "helpers of tests fail by panicking"
)]

mod convergence;
mod delays;
mod evidence;
mod few;
mod health;
mod invariance;
mod kernelled;
mod linear;
mod many_maxima;
mod maxima;
mod nist;
mod posterior;
mod problems;
mod refusals;
mod samplers;
mod simulated;
mod stages;
mod structured;
