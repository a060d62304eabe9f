//! Rational functions of s near tables of gain and phase over frequency. Must not know of what they are
//! measured.
//!
//! `rows` holds a table; `aaa` finds poles; `relocate` finds residues and poles by linear least squares,
//! `polish` the minimum; `table` fits with both, or `table_error` says why not; `likely` finds the other fits
//! that noise allows.

mod aaa;
mod likely;
mod polish;
mod relocate;
mod rows;
mod table;
mod table_error;

pub use likely::Likely;
pub use rows::{Doubt, TableRow, doubt, doubt_of_flame, phase_slope, too_late};
pub use table::Table;
pub use table_error::TableError;
