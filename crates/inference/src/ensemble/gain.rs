//! The gain of an analysis by its spectrum.

use super::EnsembleError;
use super::moments::centred;
use super::observed::White;
use rijke_numerics::{Matrix, symmetric_eigen};

/// Spectral form of S'S (members) or S S' (data), whichever is smaller; serves weights and square root alike.
pub(super) struct Gain {
    pub(super) eigenvalues: Vec<f64>,
    /// Rows: members. Columns: v_k sqrt(lambda_k), the images of the data's eigenvectors, or the v_k
    /// themselves.
    right: Matrix,
    /// Observations by k: the data's eigenvectors u_k, or the images S v_k.
    left: Matrix,
    members_smaller: bool,
}

impl Gain {
    /// From S' (members by observations).
    pub(super) fn new(s: &Matrix) -> Result<Self, EnsembleError> {
        let members_smaller = s.rows() < s.columns();
        let transposed = s.transpose();
        if members_smaller {
            let (values, right) = symmetric_eigen(&s.product(&transposed))?;
            let left = transposed.product(&right);
            Ok(Self { eigenvalues: clip(values), right, left, members_smaller })
        } else {
            let (values, left) = symmetric_eigen(&transposed.product(s))?;
            let right = s.product(&left);
            Ok(Self { eigenvalues: clip(values), right, left, members_smaller })
        }
    }

    /// For every row r of `pulls` (whitened) the combination r' S (I + S'S)^{-1} of the rows of `anomalies`.
    /// Both spectral forms read the same: the weights over the members are left' r / (1 + lambda) seen
    /// through `right`.
    pub(super) fn move_by(&self, pulls: &Matrix, anomalies: &Matrix) -> Matrix {
        let mut coordinates = pulls.product(&self.left);
        for row in coordinates.as_mut_slice().chunks_mut(self.eigenvalues.len().max(1)) {
            row.iter_mut().zip(&self.eigenvalues).for_each(|(c, l)| *c /= 1.0 + l);
        }
        coordinates.product(&self.right.transpose().product(anomalies))
    }

    /// The members after the symmetric square root: Kalman's mean and sample covariance.
    pub(super) fn square_root(&self, members: &Matrix, white: &White) -> Matrix {
        let (mean, anomalies) = centred(members);
        let departure = Matrix::from_fn(1, white.departure.len(), |_, j| white.departure[j]);
        let shift = self.move_by(&departure, &anomalies);
        let shrunk = self.shrink(&anomalies);
        Matrix::from_fn(anomalies.rows(), anomalies.columns(), |i, j| {
            mean[j] + shift[(0, j)] / white.root + shrunk[(i, j)]
        })
    }

    /// (I + S'S)^{-1/2} times the anomalies. Written as I + right diag(f) right', with
    /// f = ((1 + lambda)^{-1/2} - 1)/lambda for images of the data's eigenvectors, free of cancellation.
    fn shrink(&self, anomalies: &Matrix) -> Matrix {
        let mut coordinates = self.right.transpose().product(anomalies);
        for (k, &l) in self.eigenvalues.iter().enumerate() {
            let root = (1.0 + l).sqrt();
            let over_lambda = -1.0 / (root * (1.0 + root));
            let factor = if self.members_smaller { l * over_lambda } else { over_lambda };
            let columns = coordinates.columns();
            coordinates.as_mut_slice()[k * columns..(k + 1) * columns].iter_mut().for_each(|c| *c *= factor);
        }
        anomalies.plus(1.0, &self.right.product(&coordinates))
    }
}

/// Rounding can leave eigenvalues of a semidefinite matrix just below zero.
fn clip(values: Vec<f64>) -> Vec<f64> {
    values.into_iter().map(|v| v.max(0.0)).collect()
}
