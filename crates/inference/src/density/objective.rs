//! A negative log density with derivatives.

use crate::error::InferenceError;
use rijke_numerics::{Matrix, Order};

/// A negative log density J(z) in working coordinates: what the minimiser, Laplace's method and the samplers
/// need.
pub trait Objective: Sync {
    /// Number of coordinates.
    fn size(&self) -> usize;

    /// J and its derivatives up to `order`.
    ///
    /// # Errors
    /// A recoverable error ([`InferenceError::is_recoverable`]) says that the point is out of reach.
    fn evaluate(&self, z: &[f64], order: Order) -> Result<Energy, InferenceError>;

    /// A point in words, for people.
    fn named_point(&self, z: &[f64]) -> String {
        format!("{z:?}")
    }

    /// Typical change of each coordinate, for the first step; positive, infinite if nothing is known of it.
    fn scales(&self) -> Vec<f64> {
        vec![1.0; self.size()]
    }
}

/// A negative log density and its derivatives at one point.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Energy {
    /// J, in nats.
    pub value: f64,
    /// dJ/dz; empty below [`Order::First`].
    pub gradient: Vec<f64>,
    /// d2J/dz2; 0 x 0 below [`Order::Second`].
    pub hessian: Matrix,
    /// A positive semidefinite approximation of the Hessian that needs first derivatives alone
    /// (Gauss-Newton), if there is one; it also sets the shape of trust regions.
    pub gauss_newton: Option<Matrix>,
}
