//! The whole answer for one model, and whether it can be trusted: all maxima, the summed evidence, every check (`assess`,
//! `health`), refits of simulated data (`simulate`), stages in a row (`chain`), the record on file (`record`).
//!
//! Knows everything below; nothing in this crate but its root knows it.

pub(crate) mod assess;
pub(crate) mod chain;
pub(crate) mod checks;
pub(crate) mod health;
pub(crate) mod record;
pub(crate) mod simulate;
pub(crate) mod surveyed;
