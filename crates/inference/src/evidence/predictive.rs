//! What a fitted model says about data: posterior predictions.

use super::laplace::Laplace;
use crate::error::InferenceError;
use crate::problem::Forward;
use rijke_numerics::{Matrix, Order};
use std::f64::consts::PI;

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

    /// Points of the ellipse that holds `sds` standard deviations of two physical parameters (joint contour:
    /// every point lies at that Mahalanobis distance in the plane, all other parameters integrated out).
    #[must_use]
    pub fn contour(&self, i: usize, j: usize, sds: f64, points: usize) -> Vec<[f64; 2]> {
        let c = &self.physical_covariance;
        let a = c[(i, i)].sqrt();
        let (b, d) = (c[(i, j)] / a, (c[(j, j)] - c[(i, j)].powi(2) / c[(i, i)]).max(0.0).sqrt());
        (0..points)
            .map(|k| {
                let (s, cos) = (2.0 * PI * k as f64 / points as f64).sin_cos();
                [self.parameters[i] + sds * a * cos, self.parameters[j] + sds * (b * cos + d * s)]
            })
            .collect()
    }
}
