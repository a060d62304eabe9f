//! The Cholesky factor of a covariance.

use crate::dense::{DenseError, Matrix, dot};
use faer::Side;
use faer::linalg::solvers::DenseSolveCore;

/// The factor L of a symmetric positive definite matrix, A = L L'.
#[derive(Clone, Debug)]
pub struct Cholesky {
    lower: Matrix,
    factor: faer::linalg::solvers::Llt<f64>,
}

impl Cholesky {
    /// Factorises `a`; only its lower triangle is read.
    ///
    /// # Errors
    /// [`DenseError::NotPositiveDefinite`], also when `a` holds a NaN; [`DenseError::Shape`] unless it is
    /// square.
    pub fn new(a: &Matrix) -> Result<Self, DenseError> {
        a.square()?;
        let factor = a.to_faer().llt(Side::Lower).map_err(|error| {
            let faer::linalg::solvers::LltError::NonPositivePivot { index } = error;
            DenseError::NotPositiveDefinite { size: a.rows(), pivot: index }
        })?;
        let l = factor.L();
        let lower = Matrix::from_fn(a.rows(), a.rows(), |i, j| if j <= i { l[(i, j)] } else { 0.0 });
        Ok(Self { lower, factor })
    }

    /// The lower factor L.
    #[must_use]
    pub fn lower(&self) -> &Matrix {
        &self.lower
    }

    /// A^{-1} b.
    ///
    /// # Panics
    /// Unless `b` has a number for each row.
    #[must_use]
    pub fn solve(&self, b: &[f64]) -> Vec<f64> {
        // Blocks of data are small: the allocations of a blocked solver would cost more than the solution.
        let mut x = self.whiten(b);
        for i in (0..x.len()).rev() {
            let row = self.lower.row(i);
            x[i] /= row[i];
            let xi = x[i];
            for (x, l) in x[..i].iter_mut().zip(row) {
                *x -= l * xi;
            }
        }
        x
    }

    /// A^{-1}.
    #[must_use]
    pub fn inverse(&self) -> Matrix {
        let inverse = self.factor.inverse();
        Matrix::from_fn(self.lower.rows(), self.lower.rows(), |i, j| inverse[(i, j)])
    }

    /// ln det A, from the diagonal of L so that it neither overflows nor underflows.
    #[must_use]
    pub fn ln_det(&self) -> f64 {
        (0..self.lower.rows()).map(|i| 2.0 * self.lower[(i, i)].ln()).sum()
    }

    /// L^{-1} b: the vector in units of its own standard deviations, if A is a covariance.
    ///
    /// # Panics
    /// Unless `b` has a number for each row.
    #[must_use]
    pub fn whiten(&self, b: &[f64]) -> Vec<f64> {
        assert_eq!(b.len(), self.lower.rows(), "a vector needs one number for each row");
        forward(&self.lower, b)
    }
}

/// The solution y of L y = b by forward substitution; of L only the lower triangle is read, and as many rows
/// as `b` has.
///
/// # Panics
/// If `b` is longer than L.
#[must_use]
pub fn forward(lower: &Matrix, b: &[f64]) -> Vec<f64> {
    let mut y: Vec<f64> = Vec::with_capacity(b.len());
    for (i, b) in b.iter().enumerate() {
        let row = lower.row(i);
        y.push((b - dot(&row[..i], &y)) / row[i]);
    }
    y
}
