//! From readings of states to base states: one heater position, several powers, each long after its step, or
//! passed at a known time of a ramp, whose power was logged.
//!
//! This serves a campaign that keeps the mean click of every operating point, and users with thermometers or
//! a sound speed profile instead. Without the warm-up the wall is seen only through its settled effect, so
//! less is known than from [`crate::assimilate::Batch`]; what the closures leave open then matters, and is
//! inferred along with the six parameters under priors that say what handbooks and geometry leave open
//! ([`unknowns`]). The posterior therefore holds the error of the model as far as these closures describe it.
//! Knows nothing of records over time with many samples.
//!
//! # Likelihood
//!
//! All readings of all states together are one Gaussian vector, with noise per state ([`State::noise`]) and
//! an error of the arrival times that is common to all states ([`SettledRun::common`]).

mod bend;
#[cfg(test)]
mod dense;
mod errors;
mod fit;
#[cfg(test)]
mod foreseen;
mod infer;
mod joint;
mod observed;
mod of_run;
mod prediction;
mod readings;
mod report;
mod run;
mod search;
mod settling;
#[cfg(test)]
mod tests;
mod unknowns;

pub use super::report::SettlingReport;
pub use fit::JointFit;
pub use infer::{heated, infer};
pub use of_run::{ReadingMisfit, Settled};
pub use readings::Readings;
pub use run::{SettledRun, State};
pub use unknowns::unknowns;
