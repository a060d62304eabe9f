//! `rijke predict` of a stage of responses: reflection, transfer and absorption with their uncertainty.

use crate::condition::condition;
use crate::ui::Ui;
use rijke_engine::folder::RankedResponses;
use rijke_numerics::{Failed, write_output};
use serde_json::json;
use std::path::Path;

/// More frequencies than this are a slip of the step.
const MOST: f64 = 1e5;

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

/// A frequency, or `from:to:step`.
fn frequencies(text: &str) -> Result<Vec<f64>, Failed> {
    let wrong = |what: &str| {
        Failed::bad_input(format!("--at-hz {text}: {what}"))
            .remedy("Give frequencies in Hz, or from:to:step as in --at-hz 100:2000:10.")
    };
    let numbers: Option<Vec<f64>> = text.split(':').map(|part| part.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some([hertz]) if hertz.is_finite() && *hertz > 0.0 => Ok(vec![*hertz]),
        Some([from, to, step]) if *from > 0.0 && to >= from && *step > 0.0 && to.is_finite() => {
            let count = ((to - from) / step + 1e-9).floor();
            if count > MOST {
                return Err(wrong(&format!("these are {count} frequencies; {MOST} are the most")));
            }
            Ok((0..=count as usize).map(|k| from + step * k as f64).collect())
        }
        _ => Err(wrong("neither a frequency nor a range")),
    }
}
