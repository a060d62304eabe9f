//! A study, run: its stages in order, each a competition of candidates on some points. Must not know how numbers are drawn.

mod assumed;
mod competition;
mod inputs;
mod matching;
mod record;

pub use competition::{Chosen, Run, Trusted};
pub(crate) use inputs::conditions_at;
pub use record::{EvidenceRecord, MeasuredRecord, ModelRecord, ParameterRecord, StageRecord};
