#![doc = include_str!("../README.md")]

mod formula;
mod inspect;
mod read;
mod run;
#[cfg(test)]
mod tests;

pub use formula::Formula;
pub use inspect::is_unit;
pub use read::{Context, FormulaError, Kind, Name, NameError, Problem, Scope};
pub use run::{Dual, Here};
