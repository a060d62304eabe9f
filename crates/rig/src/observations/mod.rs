//! Observations: pings and clicks with their covariances, to and from CSV.
//!
//! Knows how records are named, not how observations were made of them.

pub(crate) mod channels;
mod dead;
pub(crate) mod observation;
mod row;
pub(crate) mod rows;
mod table;
