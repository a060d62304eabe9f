//! The apparatus: gas, tube, instruments, and the campaign of operating points, from their files.
//!
//! Knows no record.

pub(crate) mod campaign;
pub(crate) mod gas;
pub(crate) mod geometry;
pub(crate) mod point;
pub(crate) mod ramp;
mod rig_file;
