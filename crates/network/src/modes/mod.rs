//! Modes of the chain at rest: the one nearest a guess, and all in a region.
//!
//! Brings the chain to the methods of `plane`; knows nothing of what is asked of a mode afterwards.

pub(crate) mod contour;
mod solve;
