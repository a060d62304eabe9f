#![doc = include_str!("../README.md")]

mod formula;
mod inspect;
mod read;
mod run;
#[cfg(test)]
mod tests;

pub use formula::Formula;
pub use inspect::is_unit;
pub use read::{Context, FormulaError, FormulaProblem, Kind, Name, NameError, Scope};
pub use run::Here;
