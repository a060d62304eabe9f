//! What `rijke flow` found, as a file for figures.

use rijke_flow::assimilate::RunReport;
use rijke_rig::DataKind;
use serde::Serialize;

/// OUT/flow.json.
#[derive(Serialize)]
pub(super) struct Document {
    pub(super) kind: DataKind,
    pub(super) rig: String,
    pub(super) seed: u64,
    pub(super) runs: Vec<RunReport>,
}
