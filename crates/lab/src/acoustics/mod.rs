//! Acoustics: the lossy line with continuous c(x), what radiates from its open ends, and what stands in it.
//!
//! Knows no truth file and no rig; [`crate::bench`](mod@crate::bench) and the apparatus are put together from
//! it.

pub mod duct;
pub mod obstacle;
pub mod radiation;
pub mod walls;
