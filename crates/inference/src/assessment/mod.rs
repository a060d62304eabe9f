//! The whole answer for one model, and whether it can be trusted: all maxima, the summed evidence, every
//! check (`assess`, `health`), refits of simulated data (`simulate`), stages in a row (`chain`), the record
//! on file (`record`).
//!
//! Knows everything below; nothing in this crate but its root knows it.

mod assess;
mod chain;
mod checks;
mod health;
mod record;
mod simulate;
mod surveyed;

pub use assess::{AssessOptions, Assessment, assess};
pub use chain::{ChainStage, EvidenceChain};
pub use health::Health;
pub use record::{Draws, InferenceRecord, ParameterRecord};
pub use simulate::{ModelCheck, ParameterCheck, SimulatedCoverage};
pub use surveyed::{Surveyed, survey};
