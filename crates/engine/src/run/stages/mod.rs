//! The table of a stage: the rows that are trained, which of them goes on, and what later stages make of
//! those that stay open.

pub(super) mod ahead;
pub(super) mod assumed;
pub(super) mod average;
pub(super) mod compete;
pub(super) mod earlier;
pub(super) mod maxima;
pub(super) mod next_stage;
pub(super) mod once;
pub(super) mod rows;
