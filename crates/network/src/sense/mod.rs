//! What a mode of the chain at rest is sensitive to: every local coefficient by the adjoint, a small change
//! anywhere along it, and where its energy comes from.
//!
//! Knows a mode as its root; it finds none.

pub(crate) mod advice;
pub(crate) mod along;
pub(crate) mod budget;
pub(crate) mod curves;
mod distant_reference;
mod piece;
pub(crate) mod sensitivity;
