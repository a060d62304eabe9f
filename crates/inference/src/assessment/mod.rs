//! The whole answer for one model, and whether it can be trusted: all maxima, the summed evidence, every
//! check (`assess`, `health`), the record on file (`record`).
//!
//! Knows everything below; nothing in this crate but its root knows it.

mod assess;
mod checks;
mod health;
mod judged;
mod record;

pub use assess::{AssessOptions, Assessment, assess};
pub use health::{ChiSquared, Health};
pub use record::{Draws, InferenceRecord, ParameterRecord};
