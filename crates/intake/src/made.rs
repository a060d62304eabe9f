//! What every kind of excited record leaves behind: names and texts of files, and an answer.

use rijke_numerics::Failed;
use rijke_rig::{DataKind, ExcitedRecords};
use rijke_study::Study;
use serde_json::{Value, json};

/// Names and texts of files.
pub(crate) type Files = Vec<(String, String)>;

/// Files, and what they say as JSON.
pub(crate) type Made = (Files, Value);

/// The head of `observations.toml`.
pub(crate) fn head(records: &ExcitedRecords) -> String {
    let kind = if records.kind == DataKind::Measured { "measured" } else { "virtual" };
    format!("kind = \"{kind}\"\nsource = {}\n", json!(records.source))
}

/// The place of an operating point that the manifest names.
pub(crate) fn point_of(
    study: &Study,
    point: &str,
    key: &str,
    records: &ExcitedRecords,
) -> Result<usize, Failed> {
    study.campaign.point(point).map(|(index, _)| index).ok_or_else(|| {
        let known: Vec<&str> = study.campaign.points.iter().map(|p| p.id.as_str()).collect();
        Failed::bad_input(format!("there is no operating point `{point}`; known: {}", known.join(", ")))
            .at(&records.path)
            .remedy(format!("Correct the name in {key}, or add the point to the campaign."))
    })
}
