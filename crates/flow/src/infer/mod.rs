//! From readings to base states: what both ways of inference share, and the two ways.
//!
//! [`assimilate`] takes the clicks of a run over time, [`settled`] the mean readings of states long after
//! their step. Neither knows the other; they share sensors, normal scores, health and reports.

pub mod assimilate;
pub(crate) mod health;
pub(crate) mod report;
pub(crate) mod scores;
pub(crate) mod sensor;
pub mod settled;
pub(crate) mod tension;
