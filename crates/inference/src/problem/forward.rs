//! The model: from physical parameters to predicted data.

use crate::error::ForwardError;
use rijke_numerics::{Matrix, Order};

/// A model of the data with derivatives. Object safe; knows neither priors nor transforms.
///
/// The predicted numbers come observation after observation, in the order of [`crate::Data`].
pub trait Forward: Sync {
    /// Predicts the data, with derivatives with respect to the physical parameters up to `order`.
    ///
    /// # Errors
    /// A recoverable [`ForwardError`] shortens the step of a minimiser; a fatal one ends the fit.
    fn predict(&self, parameters: &[f64], order: Order) -> Result<Prediction, ForwardError>;

    /// Other physical parameters at which the model predicts nearly the same as at these, as far as it knows:
    /// a delay one period of its wave earlier and later, a gain of the other sign. One step of each kind is
    /// enough: images of images are looked at, as far as the prior reaches. Searches start there, too.
    /// Those that names suffice for can be said with [`crate::Parameters::with_alias`].
    fn aliases(&self, parameters: &[f64]) -> Vec<Vec<f64>> {
        let _ = parameters;
        Vec::new()
    }

    /// The highest derivative on offer. Below [`Order::Second`] the Hessian of the cost is the Gauss-Newton
    /// one, and results say so; [`Order::Value`] is not enough for a fit.
    fn highest_order(&self) -> Order {
        Order::Second
    }
}

/// Predicted data and their derivatives.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Prediction {
    /// m predicted numbers.
    pub values: Vec<f64>,
    /// m x p first derivatives; not read below [`Order::First`].
    pub jacobian: Matrix,
    /// Second derivatives: for each of the m values in turn, the lower triangle of a p x p matrix row by row
    /// ((0,0), (1,0), (1,1), ...); not read below [`Order::Second`].
    pub curvature: Vec<f64>,
}
