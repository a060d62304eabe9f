//! The question: what is unknown and what was known of it before (`prior`, `parameter`, `parameters`), what was measured
//! with which noise (`data`, `structured`), and what a model predicts (`forward`).
//!
//! Knows no likelihood, no search and no answer.

pub(crate) mod alias;
pub(crate) mod data;
pub(crate) mod forward;
pub(crate) mod images;
pub(crate) mod kernelled;
pub(crate) mod misfit;
pub(crate) mod parameter;
pub(crate) mod parameters;
pub(crate) mod prior;
pub(crate) mod scale;
pub(crate) mod structured;
