//! What one maximum is worth: Laplace's method and its evidence (`laplace`), the noise that makes it largest (`marginal`),
//! the distance from the priors (`conflict`), predictions and residuals (`predictive`), models side by side (`rank`).
//!
//! Knows one maximum, and does not ask whether Laplace's Gaussian is right.

pub(crate) mod conflict;
pub(crate) mod laplace;
pub(crate) mod marginal;
pub(crate) mod predictive;
pub(crate) mod rank;
