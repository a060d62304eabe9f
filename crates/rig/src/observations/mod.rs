//! Observations: pings and clicks with their covariances, to and from CSV.
//!
//! Knows how records are named, not how observations were made of them.

pub(crate) mod channels;
mod dead;
mod factors;
pub(crate) mod observation;
pub(crate) mod row;
pub(crate) mod rows;
pub(crate) mod table;
