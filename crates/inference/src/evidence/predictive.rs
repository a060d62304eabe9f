//! What a fitted model says about data: posterior predictions, residuals, and leave-one-out scores.

use super::laplace::Laplace;
use crate::covariance::dense_enough;
use crate::error::InferenceError;
use crate::fit::{Fit, Posterior};
use crate::problem::Forward;
use rijke_numerics::{Cholesky, Matrix, Order};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// A Gaussian prediction of m real numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Predicted {
    /// Prediction with the best parameters.
    pub mean: Vec<f64>,
    /// Covariance that the parameters cause, to first order: F A^-1 F'. Noise of a measurement is not part of it.
    pub covariance: Matrix,
}

/// One observation against the model that was fitted to it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Residual {
    /// Label of the observation.
    pub label: String,
    /// Measured minus predicted.
    pub raw: Vec<f64>,
    /// The same in units of each datum's own predictive sd (noise and parameters).
    pub standardised: Vec<f64>,
    /// r'(C + F A^-1 F')^-1 r over the whole block: chi-squared with as many degrees of freedom as data, if the data
    /// had not been used in the fit.
    pub mahalanobis_squared: f64,
    /// ln of the density of this block given all others, nats: the leave-one-out score.
    pub ln_left_out: f64,
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

    /// Points of the ellipse that holds `sds` standard deviations of two physical parameters (joint contour: every
    /// point lies at that Mahalanobis distance in the plane, all other parameters integrated out).
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

impl Posterior<'_> {
    /// Residuals and leave-one-out scores of every observation.
    ///
    /// The score of a block is exact for linear-Gaussian models: with Sigma the covariance of the fit, the fit without
    /// the block has F Sigma F' replaced by G = S (I - C^-1 S)^-1, S = F Sigma F' (Woodbury), and its residual grows by
    /// (I - S C^-1)^-1. Otherwise it holds to first order about the fit; noise stays as fitted.
    ///
    /// # Errors
    /// Those of the model, and [`InferenceError::Dense`] if a block alone decides a parameter.
    pub fn residuals(&self, fit: &Fit, laplace: &Laplace) -> Result<Vec<Residual>, InferenceError> {
        let sds = self.noise_sd(&fit.working);
        let prediction = self.predict(&fit.parameters, Order::First)?;
        let p = self.parameters().len();
        let mut first = 0;
        let mut out = Vec::with_capacity(self.data().observations().len());
        for (k, observation) in self.data().observations().iter().enumerate() {
            let n = observation.values.len();
            dense_enough(&observation.label, n)?;
            let f = Matrix::from_fn(n, p, |i, j| prediction.jacobian[(first + i, j)]);
            let spread = f.product(&laplace.physical_covariance).product(&f.transpose());
            let noise = self.covariance(k, &sds);
            let raw: Vec<f64> =
                (0..n).map(|i| observation.values[i] - prediction.values[first + i]).collect();
            let total = noise.plus(1.0, &spread);
            let whole = Cholesky::new(&total)?;
            // The residual without the block is C (C - S)^-1 r, and its covariance C (C - S)^-1 C.
            let gap = Cholesky::new(&noise.plus(-1.0, &spread))?;
            let without = noise.times(&gap.solve(&raw));
            let half: Vec<Vec<f64>> = (0..n).map(|i| gap.whiten(noise.row(i))).collect();
            let left_out = Cholesky::new(&Matrix::from_fn(n, n, |i, j| {
                half[i].iter().zip(&half[j]).map(|(a, b)| a * b).sum()
            }))?;
            let square = |factor: &Cholesky, r: &[f64]| factor.whiten(r).iter().map(|w| w * w).sum::<f64>();
            out.push(Residual {
                label: observation.label.clone(),
                standardised: (0..n).map(|i| raw[i] / total[(i, i)].sqrt()).collect(),
                mahalanobis_squared: square(&whole, &raw),
                ln_left_out: -0.5
                    * (square(&left_out, &without) + left_out.ln_det() + n as f64 * (2.0 * PI).ln()),
                raw,
            });
            first += n;
        }
        Ok(out)
    }
}
