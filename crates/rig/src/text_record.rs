//! Records as text: one row per sample, one column per channel, in Pa.

use crate::wav::{Layout, finite, spread};
use crate::{Problem, Record, RigError};
use std::path::Path;

/// Reads one record from text: comma, semicolon or tab between columns, an optional first line of names, a decimal
/// point. The sampling rate is the manifest's: text does not carry one.
///
/// # Errors
/// The file is absent, a row lacks a channel, a cell is no number, or a value is NaN or infinite.
pub(crate) fn read_text_record(path: &Path, layout: Layout<'_>) -> Result<Record, RigError> {
    let wrong = |place: String, problem| RigError::invalid(path, place, problem);
    let bytes = std::fs::read(path).map_err(RigError::read(path))?;
    let text = String::from_utf8_lossy(&bytes);
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let (separator, named) = shape(text);
    let (need, mut samples, mut frames) = (layout.channels.len(), Vec::new(), 0);
    for (k, line) in
        text.lines().enumerate().skip(usize::from(named)).filter(|(_, line)| !line.trim().is_empty())
    {
        let have = line.split(separator).count();
        if have < need {
            return Err(wrong(format!("line {}", k + 1), Problem::MissingChannel { have, need }));
        }
        for (column, cell) in line.split(separator).take(need).enumerate() {
            let value = cell.trim().parse::<f64>().map_err(|_| {
                let (text, expected) = (cell.trim().to_owned(), "a number with a decimal point");
                wrong(format!("line {}, column {}", k + 1, column + 1), Problem::BadCell { text, expected })
            })?;
            samples.push(value);
        }
        frames += 1;
    }
    if frames <= layout.quiet {
        return Err(wrong("samples".into(), Problem::TooShort { have: frames, quiet: layout.quiet }));
    }
    let record = spread(layout, frames, f64::INFINITY, |k| samples[k]);
    finite(&record).map_err(|(place, problem)| wrong(place, problem))?;
    Ok(record)
}

/// The character between columns, and whether the first line holds names. A line of names has no number in it; one with
/// some numbers is data, and its bad cells are reported.
fn shape(text: &str) -> (char, bool) {
    let first = text.lines().next().unwrap_or("");
    let separator = [';', '\t', ','].into_iter().find(|c| first.contains(*c)).unwrap_or(',');
    (separator, first.split(separator).all(|cell| cell.trim().parse::<f64>().is_err()))
}

/// The columns of a text record, with their names if it has any.
pub(crate) fn columns(path: &Path) -> Result<Vec<Option<String>>, RigError> {
    let bytes = std::fs::read(path).map_err(RigError::read(path))?;
    let text = String::from_utf8_lossy(&bytes);
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let (separator, named) = shape(text);
    let first = text.lines().next().unwrap_or("");
    Ok(first.split(separator).map(|cell| named.then(|| cell.trim().to_owned())).collect())
}
