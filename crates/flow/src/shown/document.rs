//! What was found, as one file.

use crate::infer::report::RunReport;
use rijke_rig::DataKind;
use serde::Serialize;

/// `flow.json`: all that was inferred, for figures.
#[derive(Clone, Debug, Serialize)]
pub struct FlowDocument {
    /// Whether the data behind it were measured.
    pub kind: DataKind,
    /// The rig.
    pub rig: String,
    /// Seed of all random numbers.
    pub seed: u64,
    /// One entry per place of the heater.
    pub runs: Vec<RunReport>,
}
