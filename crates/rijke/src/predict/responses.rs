//! `rijke predict` of a stage of responses: reflection, transfer and absorption with their uncertainty.

use crate::ui::Ui;
use rijke_engine::folder::{RankedResponses, condition, frequencies};
use rijke_numerics::{Failed, write_output};
use serde_json::json;
use std::path::Path;

/// What standard deviations of predictions leave out.
pub(super) const MODEL: &str = "standard deviation of the model alone";

/// Predicts at the conditions `at` and the frequencies `at_hz`, as they were written, into the file `out` or
/// onto the terminal.
pub(super) fn run(
    ranked: &RankedResponses,
    [at, at_hz]: [&[String]; 2],
    out: Option<&Path>,
    ui: &Ui,
) -> Result<(), Failed> {
    let (stage, candidates) = ranked.model();
    let asked = at.iter().map(|text| condition("--at", text)).collect::<Result<Vec<_>, _>>()?;
    let frequency_hz = at_hz.iter().map(|text| frequencies(text)).collect::<Result<Vec<_>, _>>()?.concat();
    let found = ranked.predict(&asked, &frequency_hz, ui)?;
    let text = ranked.csv(&found)?;
    match out {
        Some(path) => write_output(path, text.as_bytes())?,
        None => ui.say(text.trim_end()),
    }
    let columns = json!({ "value": ["real", "imaginary"], "covariance": ["of real", "of imaginary", "of both"], "sd": MODEL });
    ui.result(&json!({ "stage": stage, "candidates": candidates, "columns": columns, "responses": found }))
}
