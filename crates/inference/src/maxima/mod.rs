//! All maxima: the search from many starts (`explore`), what it stands on (`grounds`), the maxima side by
//! side (`modes`); starts of delays (`scan`).
//!
//! Knows the evidence of each maximum, and does not ask whether it can be trusted.

mod explore;
mod grounds;
mod modes;
mod scan;

pub use modes::{Apart, Maximum, OtherMaximum, further_maxima};
pub use scan::Scan;

pub(crate) use explore::{Breadth, Explored, Peak, explore};
pub(crate) use grounds::{Plain, Terrain};
pub(crate) use modes::{Sorted, shares, sorted};
