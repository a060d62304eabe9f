//! Reading and writing whole files: TOML with the place of every error, and writes that are never half done.

use crate::error::RigError;
use crate::problem::Problem;
use rijke_numerics::words::{line_of, of_toml};
use rijke_numerics::{Classify, Failed};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

/// The whole of a text file.
///
/// # Errors
/// The file cannot be read.
pub fn read_text(path: &Path) -> Result<String, RigError> {
    rijke_numerics::read_text(path).map_err(RigError::read(path))
}

/// Parses TOML; errors carry line and column.
///
/// # Errors
/// [`RigError::Syntax`].
pub fn parse_toml<T: DeserializeOwned>(text: &str, path: &Path) -> Result<T, RigError> {
    toml::from_str(text).map_err(|error| {
        let offset = error.span().map_or(0, |span| span.start).min(text.len());
        let before = text.get(..offset).unwrap_or("");
        RigError::Syntax {
            path: path.to_owned(),
            line: line_of(text, offset),
            column: 1 + before.rsplit('\n').next().map_or(0, |line| line.chars().count()),
            message: of_toml(error.message()),
        }
    })
}

/// TOML of `value` below the words `header`, for a file of ours.
///
/// # Errors
/// The file cannot be written.
pub fn write_toml<T: Serialize>(value: &T, header: &str, path: &Path) -> Result<(), RigError> {
    let body = toml::to_string(value)
        .map_err(|error| RigError::Write { path: path.to_owned(), cause: std::io::Error::other(error) })?;
    write_whole(path, format!("{header}{body}").as_bytes())
}

/// Writes a file in one step, as [`rijke_numerics::write_whole`].
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), RigError> {
    rijke_numerics::write_whole(path, bytes).map_err(RigError::write(path))
}

/// Writes a file in one step, piece by piece, as [`rijke_numerics::write_through`].
///
/// # Errors
/// The file cannot be written.
pub fn write_through(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> std::io::Result<()>,
) -> Result<(), RigError> {
    rijke_numerics::write_through(path, write).map_err(RigError::write(path))
}

/// Makes a folder and its parents.
pub(crate) fn make_folder(path: &Path) -> Result<(), RigError> {
    std::fs::create_dir_all(path).map_err(RigError::write(path))
}

/// `value` is a number from `low` to `high`, all in `unit`; `place` is its key.
///
/// # Errors
/// The key, and [`Problem::OutOfRange`].
pub fn in_range(
    place: &str,
    value: f64,
    low: f64,
    high: f64,
    unit: &'static str,
) -> Result<(), (String, Problem)> {
    match value >= low && value <= high {
        true => Ok(()),
        false => Err((place.to_owned(), Problem::OutOfRange { value, low, high, unit })),
    }
}

/// A table as CSV (RFC 4180); the first row has the names of the columns, and all rows have as many cells.
///
/// # Errors
/// Rows of different lengths.
pub fn csv_table(rows: impl IntoIterator<Item = Vec<String>>) -> Result<String, Failed> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    rows.into_iter().try_for_each(|row| writer.write_record(row)).or_failed()?;
    String::from_utf8(writer.into_inner().or_failed()?).or_failed()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_cell_with_a_comma_is_one_cell() {
        let row = |cells: &[&str]| cells.iter().map(|cell| (*cell).to_owned()).collect::<Vec<_>>();
        let rows = [row(&["name", "p re"]), row(&["m1, upper", "0.5"])];
        assert_eq!(csv_table(rows).ok().unwrap(), "name,p re\n\"m1, upper\",0.5\n");
        assert!(csv_table([row(&["a", "b"]), row(&["1"])]).is_err());
    }
}
