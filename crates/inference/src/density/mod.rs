//! Any negative log density: its minimum (`minimise`) and the Gaussian that touches it there (`gaussian`).
//!
//! Knows no parameters, no data and no model.

mod gaussian;
mod minimise;
mod objective;
mod quadratic;
mod stop;

pub use gaussian::Gaussian;
pub use minimise::{Method, Minimum, TrustRegion, minimise};
pub use objective::{Energy, Objective};
pub use stop::{Calls, Stop};

pub(crate) use gaussian::SAME_MODE;
