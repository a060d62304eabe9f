//! A tree as a program, run on numbers that carry derivatives or on plain ones.
//!
//! Knows no text: what is wrong with a formula was said when it was read.

pub(crate) mod analytic;
pub(crate) mod calculus;
pub(crate) mod evaluate;
pub(crate) mod here;
