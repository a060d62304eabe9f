//! The chain of segments with the gas at rest: its numbers, the laws that a caller hands over, and the sweep
//! of the state (p, u) through it.
//!
//! `line` has the two functions of which a segment is made, `block` computes segments side by side, `sweep`
//! gives F(s) and F'(s), `tangents` carries first and second derivatives. Knows no question that is asked of
//! the chain.

pub(crate) mod block;
pub(crate) mod checked;
pub(crate) mod coefficients;
pub(crate) mod line;
pub(crate) mod network;
pub(crate) mod sweep;
pub(crate) mod tangents;
pub(crate) mod workspace;
