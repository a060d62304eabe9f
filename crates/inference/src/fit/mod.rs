//! One maximum of a posterior: the cost J of a model with its data (`posterior`), and the search for its
//! minimum (`map`).
//!
//! Knows no evidence, and does not ask whether there are other maxima.

mod approach;
mod chi_squared;
mod conditional;
mod map;
mod memory;
mod posterior;
mod settle;

pub use map::{Fit, MapOptions, NoiseEstimate};
pub use posterior::Posterior;

pub(crate) use approach::Approach;
pub(crate) use conditional::Conditional;
