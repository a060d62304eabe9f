//! The tube as the truth has it at one operating point: the slow flow that is really there, the heater, the
//! mouths, and all of it as one duct.
//!
//! Knows nothing of how it is recorded.

pub(crate) mod base;
pub(crate) mod heater;
pub(crate) mod mouths;
pub(crate) mod tube;
