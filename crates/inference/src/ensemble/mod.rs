//! The ensemble Kalman filter and smoother, for any model that can be run member by member.
//!
//! An [`Ensemble`] is a matrix with one member per row. A forecast runs the caller's model on every row; an
//! analysis ([`Ensemble::analyse`]) pulls the rows towards data; [`smooth`] repeats analyses of one data set
//! with inflated noise (ES-MDA). [`Diagnostics`] says when the result is not to be trusted: a filter whose
//! innovations look right can still be confident of a wrong answer.
//!
//! Knows no parameters, prior or posterior: a member is a row of numbers.
//!
//! # Conventions
//!
//! Members are rows, variables are columns. Sample covariances divide by N - 1. Noise is a covariance, never
//! a standard deviation. Variables are unbounded: map bounded ones to a normal score outside (uniform priors
//! become standard normal, and bounds cannot be crossed).

mod analysis;
mod diagnostics;
mod error;
mod forcing;
mod gain;
mod members;
mod moments;
mod observed;
mod smoother;

#[cfg(test)]
mod batch;
#[cfg(test)]
mod lorenz;
#[cfg(test)]
mod tests;

pub use analysis::{Innovation, Scheme};
pub use diagnostics::{Diagnostics, effective_rank};
pub use error::EnsembleError;
pub use forcing::orthogonal_forcing;
pub use members::{Ensemble, Failure};
pub use observed::{EnsembleData, NoiseCovariance};
pub use smoother::{Pass, Smoothed, Smoother, smooth};
