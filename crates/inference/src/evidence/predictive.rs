//! What a fitted model says about data: posterior predictions.

use super::laplace::Laplace;
use crate::error::InferenceError;
use crate::problem::Forward;
use rijke_numerics::{Matrix, Order};

/// A Gaussian prediction of m real numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Predicted {
    /// Prediction with the best parameters.
    pub mean: Vec<f64>,
    /// Covariance that the parameters cause, to first order: F A^-1 F'. Noise of a measurement is not part of
    /// it.
    pub covariance: Matrix,
}

impl Laplace {
    /// Predicts the numbers of any model with the same parameters: at other operating points, say.
    ///
    /// # Errors
    /// Those of the model.
    pub fn predict(&self, forward: &dyn Forward) -> Result<Predicted, InferenceError> {
        let p = self.parameters.len();
        let prediction = forward.predict(&self.parameters, Order::First)?;
        let m = prediction.values.len();
        if prediction.jacobian.as_slice().len() != m * p {
            let found = prediction.jacobian.as_slice().len();
            return Err(InferenceError::Shape { what: "a jacobian", found, expected: m * p });
        }
        let f = &prediction.jacobian;
        let covariance = f.product(&self.physical_covariance).product(&f.transpose());
        Ok(Predicted { mean: prediction.values, covariance })
    }
}
