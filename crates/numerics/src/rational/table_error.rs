//! Why a table cannot be fitted, and what to do about it.

use super::rows::COARSE;
use crate::{C64, DenseError};

/// Why a table cannot be fitted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TableError {
    /// Too few rows.
    #[error("a table needs at least 3 rows, but has {rows}")]
    Short {
        /// How many there are.
        rows: usize,
    },
    /// A number that cannot be.
    #[error("row {row} of the table: {what}")]
    Row {
        /// The row, from 1.
        row: usize,
        /// Which, and what to do.
        what: &'static str,
    },
    /// The tolerance is not reached.
    #[error(
        "no rational function of order {order} or less, the most that {rows} rows determine, fits the table to {tolerance:.1e} of its largest gain, the \
         best one to {reached:.1e}: give more rows, so that several fall on each turn of the phase; or raise the tolerance, if the error of the measurement is \
         as large; phases are in rad"
    )]
    NoFit {
        /// How many rows there are.
        rows: usize,
        /// Largest order tried.
        order: usize,
        /// Tolerance asked for.
        tolerance: f64,
        /// What was reached.
        reached: f64,
    },
    /// The rows are noisier than the tolerance says.
    #[error(
        "the rows of the table scatter about every rational function by {noise:.1e} of its largest gain, root mean square, and the tolerance is \
         {tolerance:.1e}: {}; phases are in rad",
        wider(*.remedy)
    )]
    Noisy {
        /// Root mean square deviation of the rows, over the largest gain.
        noise: f64,
        /// Tolerance asked for.
        tolerance: f64,
        /// Two and a half times the noise, to two digits.
        remedy: f64,
    },
    /// Phases in degrees.
    #[error(
        "the phases of neighbouring rows differ by {step:.1} rad, half of them by more, so that they seem to be in degrees: give them in rad, pi/180 times \
         the degrees"
    )]
    Degrees {
        /// Median difference of neighbours, rad.
        step: f64,
    },
    /// The fit grows without end: a pole with positive growth rate at frequencies of the table.
    #[error(
        "the fit has a pole at {at:.1} with positive growth rate, so it is no response to the past: raise the tolerance to \
         the error of the measurement; phases are in rad, and those of numbers that vary as exp(-i omega t) have the other sign"
    )]
    Unstable {
        /// The pole.
        at: C64,
    },
    /// A tolerance with which a fit says nothing.
    #[error(
        "tolerance is {value} of the largest gain, and must be above 0; a fit farther off than {COARSE} says nothing of the table: \
         give at most {COARSE}"
    )]
    Tolerance {
        /// The tolerance.
        value: f64,
    },
    /// One complex number at all frequencies.
    #[error(
        "all rows of the table are one number with a phase of {phase:.3} rad, which no answer to the past has at all frequencies: for an end write \
         `constant` with modulus and angle; a delay or a filter turns the phase with frequency"
    )]
    OneNumber {
        /// The phase, rad.
        phase: f64,
    },
    /// The algebra failed.
    #[error(
        "no rational function fits the table ({0}): raise the tolerance to the error of the measurement; phases are in rad"
    )]
    Dense(#[from] DenseError),
}

/// What to do about rows that scatter by more than the tolerance.
fn wider(remedy: f64) -> String {
    if remedy <= COARSE {
        return format!("give two to three times the scatter, tolerance = {remedy}");
    }
    "no tolerance that leaves anything of the table is as wide; check the unit of the phases, the order of the columns, and whether the rows are of one measurement"
        .to_owned()
}
