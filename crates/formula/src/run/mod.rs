//! A tree as a program, run on numbers that carry derivatives or on plain ones.
//!
//! Knows no text: what is wrong with a formula was said when it was read.

mod analytic;
mod calculus;
pub(crate) mod evaluate;
mod here;

pub use here::Here;

pub(crate) use analytic::Operand;
pub(crate) use calculus::{number_binary, number_call};
pub(crate) use evaluate::Operation;
