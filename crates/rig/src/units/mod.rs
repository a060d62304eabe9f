//! Units of quantities in files: `x [mm]`, `T (degC)`, `"12 mm"`. A file's number is converted once, where it
//! is read.
//!
//! Of the kept crates, `uom` knows units as types, not as words in a file; the table here has the units that
//! rigs and their recorders use.
//!
//! `known` is the table, `parse` reads a unit, `words` what has one. Knows no file and no rig.

mod error;
mod known;
mod parse;
mod unit;
mod words;

pub use error::UnitError;
pub use unit::Unit;
pub use words::{Given, Heading, Quantity};
