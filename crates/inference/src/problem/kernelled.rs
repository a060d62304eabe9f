//! A misfit by its kernel itself, which is exact at any length.

use super::misfit::Kernel;
use crate::error::InferenceError;
use rijke_numerics::Matrix;
use std::collections::BTreeMap;

/// A misfit by its kernel, exact at any length: parts of data that do not hear each other share its size and
/// length.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Kernelled {
    pub(crate) size: usize,
    pub(crate) length: usize,
    pub(crate) kernel: Kernel,
    pub(crate) coordinate: Vec<f64>,
    /// The rows of each part.
    pub(crate) parts: Vec<Vec<usize>>,
    /// A length to start from.
    pub(crate) middle: f64,
}

impl Kernelled {
    pub(crate) fn new(
        (size, length, kernel): (usize, usize, Kernel),
        coordinate: &[f64],
        part: &[usize],
    ) -> Result<Self, InferenceError> {
        let bad = |problem: String| {
            Err(InferenceError::BadObservation { observation: "a misfit".to_owned(), problem })
        };
        if coordinate.len() != part.len() {
            return bad(format!("{} coordinates and {} parts", coordinate.len(), part.len()));
        }
        let low = coordinate.iter().copied().fold(f64::INFINITY, f64::min);
        let high = coordinate.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if !(low < high && (high - low).is_finite() && coordinate.iter().all(|x| x.is_finite())) {
            return bad(format!("its coordinate runs from {low} to {high}"));
        }
        // Numbers of parts may be any.
        let mut parts: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (row, &p) in part.iter().enumerate() {
            parts.entry(p).or_default().push(row);
        }
        let parts: Vec<Vec<usize>> = parts.into_values().collect();
        let longest = parts.iter().map(Vec::len).max().unwrap_or(0);
        if longest > MOST {
            return bad(format!("a part of it has {longest} data, more than {MOST}; take fewer frequencies"));
        }
        let middle = 0.1 * (high - low);
        Ok(Self { size, length, kernel, coordinate: coordinate.to_vec(), parts, middle })
    }

    /// Correlations within a part and their first two derivatives with respect to ln of the length.
    pub(crate) fn correlations(&self, rows: &[usize], length: f64) -> [Matrix; 3] {
        let n = rows.len();
        let mut all = [Matrix::zeros(n, n), Matrix::zeros(n, n), Matrix::zeros(n, n)];
        for i in 0..n {
            for j in 0..=i {
                let x = self.coordinate[rows[i]] - self.coordinate[rows[j]];
                for (m, v) in all.iter_mut().zip(self.kernel.correlation_in_length(x, length)) {
                    (m[(i, j)], m[(j, i)]) = (v, v);
                }
            }
        }
        all
    }

    /// The covariance of the misfit as a dense matrix.
    pub(crate) fn dense(&self, n: usize, sds: &[f64]) -> Matrix {
        let mut all = Matrix::zeros(n, n);
        for rows in &self.parts {
            let [c, ..] = self.correlations(rows, sds[self.length]);
            for (i, a) in rows.iter().enumerate() {
                for (j, b) in rows.iter().enumerate() {
                    all[(*a, *b)] = sds[self.size].powi(2) * c[(i, j)];
                }
            }
        }
        all
    }
}

/// Most data of one part: its covariance is dense.
const MOST: usize = 2000;
