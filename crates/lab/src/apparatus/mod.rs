//! The tube as the truth has it at one operating point: the slow flow that is really there, the heater, the
//! open ends, and all of it as one duct.
//!
//! Knows nothing of how it is recorded.

pub(crate) mod base;
pub(crate) mod heater;
pub(crate) mod open_ends;
pub(crate) mod tube;
