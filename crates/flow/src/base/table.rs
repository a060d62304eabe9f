//! Tables (CSV) with a row of numbers for an operating point, whose headings have units: `at [mm]`.

use crate::error::FlowError;
use rijke_rig::{Columns, RigError};
use std::path::Path;

/// A row: its line, the name of the operating point, and the numbers in SI units.
pub(crate) type Row = (usize, String, Vec<f64>);

/// Reads the columns `point` and `wanted`, each with its SI unit; `sd` is a difference of two numbers of its
/// unit. A name that is an alternative of two, `temperature|sound_speed`, stands for the one that is there.
pub(crate) fn rows(path: &Path, wanted: &[(&str, &str)]) -> Result<Vec<Row>, FlowError> {
    let wrong = |error: RigError| FlowError::File { file: path.to_path_buf(), problem: without_path(error) };
    let columns = Columns::read(path).map_err(wrong)?;
    let names: Vec<&str> = std::iter::once("point").chain(wanted.iter().map(|w| w.0)).collect();
    columns.only(&names).map_err(wrong)?;
    let points = columns.words("point").map_err(wrong)?;
    let column = |(name, unit): &(&str, &str)| match *name {
        "sd" => columns.differences(name, unit),
        _ => columns.numbers(name, unit),
    };
    let numbers: Vec<Vec<f64>> = wanted.iter().map(column).collect::<Result<_, _>>().map_err(wrong)?;
    let row = |(k, point): (usize, &&str)| {
        (columns.line(k), (*point).to_owned(), numbers.iter().map(|column| column[k]).collect())
    };
    Ok(points.iter().enumerate().map(row).collect())
}

/// Readings of a file whose quantity is a temperature (K) or a speed of sound (m/s), by the column that it
/// has: whether it is a speed, and rows with place (m), reading and standard deviation.
pub(crate) fn readings(path: &Path) -> Result<(bool, Vec<Row>), FlowError> {
    let wrong = |error: RigError| FlowError::File { file: path.to_path_buf(), problem: without_path(error) };
    let by_speed = {
        let columns = Columns::read(path).map_err(wrong)?;
        columns.has("sound_speed") && !columns.has("temperature")
    };
    let (name, unit) = if by_speed { ("sound_speed", "m/s") } else { ("temperature", "K") };
    Ok((by_speed, rows(path, &[("at", "m"), (name, unit), ("sd", unit)])?))
}

/// What is wrong, and where in the file, which is named beside it.
fn without_path(error: RigError) -> String {
    match error {
        RigError::Invalid { place, problem, .. } => format!("{place}: {problem}"),
        other => other.to_string(),
    }
}

/// What is wrong in a line of a file.
pub(crate) fn at(path: &Path, line: usize, problem: &str) -> FlowError {
    FlowError::File { file: path.to_path_buf(), problem: format!("line {line}: {problem}") }
}
