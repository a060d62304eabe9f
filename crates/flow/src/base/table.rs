//! Tables (CSV) with a row of numbers for an operating point, whose headings have units: `at [mm]`.

use crate::error::FlowError;
use rijke_rig::{Columns, RigError};
use std::path::Path;

/// A row: its line, the name of the operating point, and the numbers in SI units.
pub(crate) type Row = (usize, String, Vec<f64>);

/// Reads the columns `point` and `wanted`, each with its SI unit; `sd` and `offset_sd` are differences of two
/// numbers of their unit.
pub(crate) fn rows(path: &Path, wanted: &[(&str, &str)]) -> Result<Vec<Row>, FlowError> {
    Columns::read(path).and_then(|columns| rows_of(&columns, wanted)).map_err(|error| of_file(path, error))
}

fn rows_of(columns: &Columns, wanted: &[(&str, &str)]) -> Result<Vec<Row>, RigError> {
    let names: Vec<&str> = std::iter::once("point").chain(wanted.iter().map(|w| w.0)).collect();
    columns.only(&names)?;
    let points = columns.words("point")?;
    let column = |(name, unit): &(&str, &str)| match *name {
        "sd" | "offset_sd" => columns.differences(name, unit),
        _ => columns.numbers(name, unit),
    };
    let numbers: Vec<Vec<f64>> = wanted.iter().map(column).collect::<Result<_, _>>()?;
    let row = |(k, point): (usize, &&str)| {
        (columns.line(k), (*point).to_owned(), numbers.iter().map(|column| column[k]).collect())
    };
    Ok(points.iter().enumerate().map(row).collect())
}

/// Readings of a file whose quantity is a temperature (K) or a speed of sound (m/s), by the column that it
/// has: whether it is a speed, and rows with place (m), reading, standard deviation and, if there is a column
/// of it, that of the error that all readings have in common.
pub(crate) fn readings(path: &Path) -> Result<(bool, Vec<Row>), FlowError> {
    let read = |columns: Columns| {
        let by_speed = columns.has("sound_speed") && !columns.has("temperature");
        let (name, unit) = if by_speed { ("sound_speed", "m/s") } else { ("temperature", "K") };
        let offset = columns.has("offset_sd").then_some(("offset_sd", unit));
        let wanted: Vec<_> = [("at", "m"), (name, unit), ("sd", unit)].into_iter().chain(offset).collect();
        Ok((by_speed, rows_of(&columns, &wanted)?))
    };
    Columns::read(path).and_then(read).map_err(|error| of_file(path, error))
}

/// What is wrong, and where in the file, which is named beside it.
fn of_file(path: &Path, error: RigError) -> FlowError {
    let problem = match error {
        RigError::Invalid { place, problem, .. } => format!("{place}: {problem}"),
        other => other.to_string(),
    };
    FlowError::File { file: path.to_path_buf(), problem }
}

/// What is wrong in a line of a file.
pub(crate) fn at(path: &Path, line: usize, problem: &str) -> FlowError {
    FlowError::File { file: path.to_path_buf(), problem: format!("line {line}: {problem}") }
}
