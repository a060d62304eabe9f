//! Ensembles: the Kalman filter that the paper describes, click by click, and the smoother ES-MDA on the
//! whole record.
//!
//! Knows the batch's model, not how it is fitted.

pub(crate) mod filter;
mod members;
pub(crate) mod smoother;
