//! The evidence by draws, without Laplace's approximation: importance sampling, and the referees (nested sampling; NUTS with
//! bridge sampling).
//!
//! Knows a fit to start from, and neither its Laplace evidence nor other maxima.

#[cfg(feature = "nuts")]
pub(crate) mod bridge;
pub(crate) mod choice;
pub(crate) mod importance;
pub(crate) mod likelihood;
pub(crate) mod nested;
#[cfg(feature = "nuts")]
pub(crate) mod nuts;
pub(crate) mod referee;
