//! The heated tube itself: its geometry, its operating points and runs, their files, and what of all this
//! signal processing and observations know.
//!
//! Knows no equation of the flow.

pub(crate) mod campaign;
pub(crate) mod folder;
pub(crate) mod geometry;
pub(crate) mod observed;
pub(crate) mod point;
pub(crate) mod ramp;
mod rig_file;
mod way;
