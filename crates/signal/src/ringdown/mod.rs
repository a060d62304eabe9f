//! Sums of damped exponentials in white noise: a first guess by subspaces, then maximum likelihood. Must not
//! know what rang.

mod component;
mod curved;
pub(crate) mod pencil;
mod solution;
mod solve;
mod sums;
mod white;

pub(crate) use component::{Component, Kind, Law, fundamental, with_fundamental};
pub(crate) use solution::Solution;
pub(crate) use solve::{MAINS, SEARCHING, SETTLING, energies, glance, solve};
pub(crate) use white::White;
