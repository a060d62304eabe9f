//! What can be wrong with a truth file, its campaign, or its modes.

use crate::toml_file::TruthFault;
use std::path::PathBuf;

/// Why a bench makes no observations.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BenchError {
    /// A file cannot be read.
    #[error("{}: cannot be read ({cause}); check the name", path.display())]
    Read {
        /// Which file.
        path: PathBuf,
        /// The operating system's reason.
        cause: std::io::Error,
    },
    /// A file cannot be written.
    #[error("{}: cannot be written ({cause})", path.display())]
    Write {
        /// Which file.
        path: PathBuf,
        /// The operating system's reason.
        cause: std::io::Error,
    },
    /// The truth file cannot be read, or does not parse.
    #[error(transparent)]
    Truth(#[from] TruthFault),
    /// The campaign is no table.
    #[error("{}: {cause}", path.display())]
    Csv {
        /// Which file.
        path: PathBuf,
        /// What the reader says.
        cause: csv::Error,
    },
    /// A column of the campaign whose unit is not known.
    #[error("{}:{line}: column `{column}`: {said}", path.display())]
    Unit {
        /// Which file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// The column.
        column: String,
        /// What is wrong with it.
        said: String,
    },
    /// A column that the campaign must have.
    #[error("{}: there is no column `{column}`; add it", path.display())]
    NoColumn {
        /// Which file.
        path: PathBuf,
        /// The column.
        column: &'static str,
    },
    /// A cell that is not the number it should be, or a row that is too short.
    #[error("{}:{line}: column `{column}` holds `{found}`, which is not a number", path.display())]
    Cell {
        /// Which file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// The column.
        column: String,
        /// What is there.
        found: String,
    },
    /// The truth names a factor that the campaign has not, or that is empty where it is needed.
    #[error("point {point}: `{factor}` has no value in the campaign; the point has {}", known.join(", "))]
    Factor {
        /// Which point.
        point: String,
        /// The factor.
        factor: String,
        /// What the point has.
        known: Vec<String>,
    },
    /// A value of the truth that makes no sense at a point.
    #[error("point {point}: {key} = {value} is outside {low} to {high}")]
    OutOfRange {
        /// Which point.
        point: String,
        /// Key.
        key: &'static str,
        /// Value found.
        value: f64,
        /// Lowest allowed.
        low: f64,
        /// Highest allowed.
        high: f64,
    },
    /// The reference microphone is not in the list.
    #[error("the reference microphone {reference} does not exist; there are {count}, from 1")]
    Reference {
        /// Its number.
        reference: usize,
        /// How many there are.
        count: usize,
    },
    /// Modes in the region of the search that the integrator did not find.
    #[error(
        "point {point}: {counted} modes are in the region of the search, {found} were found; change its bounds"
    )]
    Modes {
        /// Which point.
        point: String,
        /// What the winding number says.
        counted: i64,
        /// How many were found.
        found: usize,
    },
    /// A mode that grows: the rig would not stand still to be measured.
    #[error(
        "point {point}: the mode at {frequency_hz:.1} Hz grows with {growth_rate:.2} 1/s; leave the point out"
    )]
    Unstable {
        /// Which point.
        point: String,
        /// Its frequency, Hz.
        frequency_hz: f64,
        /// Its growth rate, 1/s.
        growth_rate: f64,
    },
}
