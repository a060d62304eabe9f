//! Means over repeats, and scatter that is learnt from all points. Must not know what was measured.

mod combine;
mod pool;

pub use combine::{Repeats, combine, pool};
pub(crate) use pool::{Group, variances_of_means};
