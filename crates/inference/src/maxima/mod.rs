//! All maxima: the search from many starts (`explore`), what it stands on (`grounds`), the maxima side by side (`modes`).
//!
//! Knows the evidence of each maximum, and does not ask whether it can be trusted.

pub(crate) mod explore;
pub(crate) mod grounds;
pub(crate) mod modes;
