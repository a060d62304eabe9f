//! What a program tells without being run: its unit, and the factor that differs from place to place.
//!
//! Knows no derivatives.

pub(crate) mod share;
pub(crate) mod units;

pub use units::is_unit;
