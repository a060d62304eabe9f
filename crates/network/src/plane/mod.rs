//! The s-plane: a rectangle of it, values with their slope in s, Newton's iteration, all zeros by the
//! argument principle, and one zero followed along a path.
//!
//! Knows analytic functions of s, and no chain.

pub(crate) mod modes;
pub(crate) mod newton;
pub(crate) mod poles;
pub(crate) mod region;
pub(crate) mod tracking;
pub(crate) mod zeros;
