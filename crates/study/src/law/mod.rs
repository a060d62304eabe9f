//! What a candidate is: parameters, and laws at places. Must not know what parts a rig has.

mod candidate;
mod parameters;
mod place;
mod table;
mod words;

pub use candidate::{Candidate, Coefficient, Effect, Hears, MeanFlow, Spread, TableUse};
pub(crate) use parameters::{Parameters, check_name, parameters};
pub use place::Place;
pub(crate) use table::{Measured, SECOND};
pub(crate) use words::{Words, named_in, words};
