//! Sums of damped exponentials in white noise: a first guess by subspaces, then maximum likelihood. Must not
//! know what rang.

mod component;
pub(crate) mod pencil;
mod solve;
mod sums;
mod white;

pub(crate) use component::{Component, Kind};
pub(crate) use solve::{SEARCHING, SETTLING, Solution, energies, glance, solve};
pub(crate) use white::White;
