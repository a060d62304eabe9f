//! One test binary; a module per subject.

#![allow(clippy::unwrap_used, clippy::panic, reason = "helpers of tests fail by panicking")]

mod linear;
mod posterior;
mod problems;
