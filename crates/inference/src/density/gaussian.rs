//! The Gaussian at a minimum.

use super::objective::Objective;
use crate::error::InferenceError;
use rijke_numerics::{Cholesky, Matrix, Order};
use std::f64::consts::PI;

/// Two ends of a search are the same maximum if they are closer than this many posterior standard deviations.
pub(crate) const SAME_MODE: f64 = 0.5;

/// A Gaussian that touches exp(-J) at a minimum of J with the same curvature.
#[derive(Clone, Debug)]
pub struct Gaussian {
    /// The minimum.
    pub mean: Vec<f64>,
    /// ln of the integral of exp(-J), if J were quadratic.
    pub ln_integral: f64,
    /// d2J/dz2 = L L'.
    factor: Cholesky,
}

impl Gaussian {
    /// The Gaussian at `z`, from the exact Hessian of `objective` there.
    ///
    /// # Errors
    /// [`InferenceError::Dense`] if the Hessian is not positive definite, and those of the objective.
    pub fn at(objective: &dyn Objective, z: &[f64]) -> Result<Self, InferenceError> {
        let energy = objective.evaluate(z, Order::Second)?;
        Self::from_hessian(z, energy.value, &energy.hessian)
    }

    /// The Gaussian with minimum `z`, where J is `value` and has the second derivatives `hessian`.
    ///
    /// # Errors
    /// [`InferenceError::Dense`] if the Hessian is not positive definite.
    pub fn from_hessian(z: &[f64], value: f64, hessian: &Matrix) -> Result<Self, InferenceError> {
        let factor = Cholesky::new(hessian)?;
        // As equation (9), of any density.
        let ln_integral = -value - 0.5 * factor.ln_det() + 0.5 * z.len() as f64 * (2.0 * PI).ln();
        Ok(Self { mean: z.to_vec(), ln_integral, factor })
    }

    /// The point that belongs to as many independent standard normal numbers: mean + L'^-1 xi.
    #[must_use]
    pub fn point(&self, xi: &[f64]) -> Vec<f64> {
        let (n, l) = (xi.len(), self.factor.lower());
        let mut offset = vec![0.0; n];
        for i in (0..n).rev() {
            let known: f64 = (i + 1..n).map(|k| l[(k, i)] * offset[k]).sum();
            offset[i] = (xi[i] - known) / l[(i, i)];
        }
        offset.iter().zip(&self.mean).map(|(o, m)| o + m).collect()
    }

    /// ln of the normalised density at the point that belongs to `xi`.
    #[must_use]
    pub fn ln_density(&self, xi: &[f64]) -> f64 {
        0.5 * self.factor.ln_det() - 0.5 * xi.iter().map(|x| x * x + (2.0 * PI).ln()).sum::<f64>()
    }

    /// Standard deviation of each coordinate.
    #[must_use]
    pub fn sd(&self) -> Vec<f64> {
        let inverse = self.factor.inverse();
        (0..self.mean.len()).map(|i| inverse[(i, i)].sqrt()).collect()
    }

    /// ln of the normalised density at a point.
    pub(crate) fn ln_density_at(&self, z: &[f64]) -> f64 {
        let square = self.distance(z).powi(2);
        0.5 * (self.factor.ln_det() - square - z.len() as f64 * (2.0 * PI).ln())
    }

    /// Distance of `z` from the mean in standard deviations (Mahalanobis).
    #[must_use]
    pub fn distance(&self, z: &[f64]) -> f64 {
        let (n, l) = (z.len(), self.factor.lower());
        let offset: Vec<f64> = z.iter().zip(&self.mean).map(|(z, m)| z - m).collect();
        (0..n).map(|j| (j..n).map(|i| l[(i, j)] * offset[i]).sum::<f64>().powi(2)).sum::<f64>().sqrt()
    }
}
