//! One block of data, and what it adds to -ln likelihood.

use crate::problem::{BlockNoise, Observation, Prediction};
use rijke_numerics::{Matrix, packed};

/// A block with everything that its likelihood depends on.
pub(crate) struct Likelihood<'a> {
    pub(crate) observation: &'a Observation,
    /// Its noises.
    pub(crate) noises: &'a [BlockNoise],
    /// Place of its first datum in the prediction.
    pub(crate) first: usize,
    /// Prediction of all data, with derivatives in working coordinates.
    pub(crate) prediction: &'a Prediction,
    /// Number of parameters; the coordinates after them are ln sd of the floating groups.
    pub(crate) parameters: usize,
    /// The groups that float; none if the noise is held.
    pub(crate) floating: &'a [usize],
    pub(crate) sds: &'a [f64],
}

/// What one block adds. The lists are empty below the order that they belong to.
#[derive(Default)]
pub(crate) struct Block {
    pub(crate) ln_likelihood: f64,
    pub(crate) gradient: Vec<f64>,
    pub(crate) gauss_newton: Matrix,
    pub(crate) curvature: Matrix,
}

impl Likelihood<'_> {
    /// The sum of residual force times second derivatives of the prediction.
    pub(crate) fn bend(&self, alpha: &[f64]) -> Matrix {
        let p = self.parameters;
        let triangle = p * (p + 1) / 2;
        let mut sum = vec![0.0; triangle];
        for (r, a) in alpha.iter().enumerate() {
            let start = (self.first + r) * triangle;
            let row = &self.prediction.curvature[start..start + triangle];
            for (s, c) in sum.iter_mut().zip(row) {
                *s += a * c;
            }
        }
        Matrix::from_fn(p, p, |i, j| sum[packed(i, j)])
    }
}

/// Adds to the entry (i, j) and to its mirror image.
pub(crate) fn add_symmetric(matrix: &mut Matrix, i: usize, j: usize, value: f64) {
    matrix[(i, j)] += value;
    if i != j {
        matrix[(j, i)] += value;
    }
}

/// Adds a matrix to the first rows and columns of another.
pub(crate) fn add_corner(to: &mut Matrix, from: &Matrix) {
    for i in 0..from.rows() {
        for j in 0..from.columns() {
            to[(i, j)] += from[(i, j)];
        }
    }
}
