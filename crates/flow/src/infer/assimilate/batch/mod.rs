//! All clicks at once: the model of a whole record, its most probable unknowns, and the posterior around
//! them.
//!
//! `model` predicts the averaged readings and whitens them; `fit` finds the maximum; `shape` draws from what
//! lies around it; `score_test` asks whether the readings want other closures. Knows no ensemble.

mod axis;
mod fit;
pub(crate) mod model;
mod score_test;
mod shape;
#[cfg(test)]
mod tests;
mod whitening;
