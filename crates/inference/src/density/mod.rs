//! Any negative log density: its minimum (`minimise`) and the Gaussian that touches it there (`gaussian`).
//!
//! Knows no parameters, no data and no model.

pub(crate) mod gaussian;
pub(crate) mod minimise;
pub(crate) mod objective;
pub(crate) mod quadratic;
pub(crate) mod stop;
