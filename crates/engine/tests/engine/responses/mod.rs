//! Training on responses, against closed forms and against likelihoods that are written out.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may fail by panicking")]

mod bench;
mod chain;
mod channels;
mod delay;
mod extends;
mod head;
mod pressures;
mod slow;
mod stated;
mod temperatures;
