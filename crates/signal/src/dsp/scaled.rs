//! Positive definite matrices whose rows differ in scale: seconds, gains and pressures; growth rates of
//! strong and weak modes.

use crate::Fault;
use rijke_numerics::{Cholesky, Matrix};

/// Solution of A x = b for a positive definite A whose rows differ in scale.
pub(crate) fn solve_scaled(a: &Matrix, b: &[f64]) -> Result<Vec<f64>, Fault> {
    let n = a.rows();
    let scale: Vec<f64> = (0..n).map(|i| a[(i, i)].sqrt().recip()).collect();
    let factor = Cholesky::new(&Matrix::from_fn(n, n, |i, j| a[(i, j)] * scale[i] * scale[j]))?;
    let scaled: Vec<f64> = b.iter().zip(&scale).map(|(v, s)| v * s).collect();
    Ok(factor.solve(&scaled).iter().zip(&scale).map(|(v, s)| v * s).collect())
}

/// Inverse of a positive definite matrix whose rows differ in scale.
pub(crate) fn inverse_scaled(a: &Matrix) -> Result<Matrix, Fault> {
    let n = a.rows();
    let scale: Vec<f64> = (0..n).map(|i| a[(i, i)].sqrt().recip()).collect();
    let inverse = Cholesky::new(&Matrix::from_fn(n, n, |i, j| a[(i, j)] * scale[i] * scale[j]))?.inverse();
    Ok(Matrix::from_fn(n, n, |i, j| inverse[(i, j)] * scale[i] * scale[j]))
}
