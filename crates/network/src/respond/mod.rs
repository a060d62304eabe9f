//! What the chain at rest answers: a mode with its derivatives in the parameters of a caller, and the forced
//! response.
//!
//! Knows how the state passes the chain, not how modes are found.

pub(crate) mod answer;
pub(crate) mod forced;
mod mode;
pub(crate) mod response;
mod values;
