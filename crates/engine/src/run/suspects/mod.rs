//! What speaks against the data of a stage, or against a model whose evidence is the best: mistakes that
//! would explain its residuals, and doubts about it.
//!
//! Knows a study with what has been trained of it. Knows no table of models and no later stage.

pub(super) mod apart;
pub(super) mod behind;
pub(super) mod doubts;
pub(super) mod ends;
pub(super) mod far;
pub(super) mod handed;
pub(super) mod matching;
pub(super) mod meters;
pub(super) mod miswired;
pub(super) mod moved_since;
pub(super) mod other_columns;
pub(super) mod recognised;
pub(super) mod relabelled;
pub(super) mod shapes;
pub(super) mod signs;
mod unexplained;
pub(super) mod written;
