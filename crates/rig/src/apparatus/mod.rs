//! The apparatus as signal processing knows it: gas, duct, instruments, and operating points with what sound
//! passes there, from their files.
//!
//! Knows no record, and not what any factor means.

mod file;
pub(crate) mod gas;
pub(crate) mod geometry;
pub(crate) mod point;
pub(crate) mod way;

pub use file::along;
