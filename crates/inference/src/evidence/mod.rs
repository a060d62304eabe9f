//! What one maximum is worth: Laplace's method and its evidence (`laplace`), the distance from the priors
//! (`conflict`), predictions and residuals (`predictive`), models side by side (`rank`).
//!
//! Knows one maximum, and does not ask whether Laplace's Gaussian is right.

mod conflict;
mod laplace;
mod predictive;
mod rank;

pub use conflict::{Conflict, ConflictWarning, LEARNT, Offset, Tension};
pub use laplace::{Evidence, Laplace};
pub use predictive::Predicted;
pub use rank::{Entry, RankedModel, Ranking, probabilities, rank};
