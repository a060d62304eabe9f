//! All maxima: the search from many starts (`explore`), what it stands on (`terrain`), the maxima side by
//! side (`modes`); starts of delays (`scan`), and far outside of the prior (`beyond`).
//!
//! Knows the evidence of each maximum, and does not ask whether it can be trusted.

mod beyond;
mod explore;
mod linkage;
mod modes;
mod orbit;
mod scan;
mod terrain;

pub use modes::{Apart, Maximum, OtherMaximum, further_maxima};
pub use scan::Scan;

pub(crate) use explore::{Breadth, Explored, Open, explore};
pub(crate) use modes::{Sorted, sorted};
pub(crate) use terrain::Terrain;
