//! The engine against closed forms, against differences and against likelihoods that are written out.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may fail by panicking")]

mod by_differences;
mod common;
mod common_errors;
mod differences;
mod elements;
mod labels;
mod missing;
mod next;
mod next_microphones;
mod responses;
mod rigs;
mod search;
mod studies;
