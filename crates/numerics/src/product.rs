//! Products of tall matrices, by the kernels of the linear-algebra library.

use crate::Matrix;
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, MatMut, MatRef, Par};

/// Rows at a time: 512 rows of some hundred columns stay in the cache.
const ROWS: usize = 512;

impl Matrix {
    /// self' diag(weights) self; rows of weight zero cost nothing.
    ///
    /// # Panics
    /// Unless there are as many weights as rows.
    #[must_use]
    pub fn weighted_gram(&self, weights: &[f64]) -> Self {
        assert_eq!(weights.len(), self.rows(), "one weight for each row");
        let q = self.columns();
        let mut out = Self::zeros(q, q);
        if q == 0 {
            return out;
        }
        self.scaled_blocks(weights, |block, scaled| {
            triangular::matmul(
                MatMut::from_row_major_slice_mut(out.as_mut_slice(), q, q),
                BlockStructure::TriangularLower,
                Accum::Add,
                rows(block, q).transpose(),
                BlockStructure::Rectangular,
                rows(scaled, q),
                BlockStructure::Rectangular,
                1.0,
                Par::Seq,
            );
        });
        for i in 0..q {
            for j in 0..i {
                out[(j, i)] = out[(i, j)];
            }
        }
        out
    }

    /// self' diag(weights) other.
    ///
    /// # Panics
    /// Unless there are as many weights as rows, and as many rows of `other`.
    #[must_use]
    pub fn weighted_product(&self, weights: &[f64], other: &Self) -> Self {
        assert_eq!((weights.len(), other.rows()), (self.rows(), self.rows()), "one weight for each row");
        let (q, p) = (self.columns(), other.columns());
        let mut out = Self::zeros(q, p);
        if q == 0 || p == 0 {
            return out;
        }
        let mut first = 0;
        while first < self.rows() {
            let last = (first + ROWS).min(self.rows());
            let scaled = scaled_rows(&other.as_slice()[first * p..last * p], &weights[first..last], p);
            matmul(
                MatMut::from_row_major_slice_mut(out.as_mut_slice(), q, p),
                Accum::Add,
                rows(&self.as_slice()[first * q..last * q], q).transpose(),
                rows(&scaled, p),
                1.0,
                Par::Seq,
            );
            first = last;
        }
        out
    }

    /// self * other, as [`Matrix::product`], for large matrices.
    ///
    /// # Panics
    /// Unless `other` has as many rows as this has columns.
    #[must_use]
    pub fn large_product(&self, other: &Self) -> Self {
        assert_eq!(self.columns(), other.rows(), "a product needs as many rows as columns");
        let mut out = Self::zeros(self.rows(), other.columns());
        let (n, q, p) = (self.rows(), self.columns(), other.columns());
        if q == 0 || p == 0 {
            return out;
        }
        matmul(
            MatMut::from_row_major_slice_mut(out.as_mut_slice(), n, p),
            Accum::Replace,
            rows(self.as_slice(), q),
            rows(other.as_slice(), p),
            1.0,
            Par::Seq,
        );
        out
    }

    /// Calls `work` with each block of rows, as it is and times its weights, unless all of them are zero.
    fn scaled_blocks(&self, weights: &[f64], mut work: impl FnMut(&[f64], &[f64])) {
        let q = self.columns();
        for (block, weights) in self.as_slice().chunks(ROWS * q.max(1)).zip(weights.chunks(ROWS)) {
            if weights.iter().any(|w| *w != 0.0) {
                work(block, &scaled_rows(block, weights, q));
            }
        }
    }
}

fn scaled_rows(block: &[f64], weights: &[f64], columns: usize) -> Vec<f64> {
    block
        .chunks_exact(columns.max(1))
        .zip(weights)
        .flat_map(|(row, w)| row.iter().map(move |v| v * w))
        .collect()
}

fn rows(block: &[f64], columns: usize) -> MatRef<'_, f64> {
    MatRef::from_row_major_slice(block, block.len() / columns.max(1), columns)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oracle_products_against_the_plain_loops() {
        for (n, q, p) in [(1, 1, 1), (7, 3, 2), (1300, 5, 4), (3, 8, 0)] {
            let a = Matrix::from_fn(n, q, |i, j| ((i * 7 + j * 3) % 11) as f64 - 5.0);
            let b = Matrix::from_fn(n, p, |i, j| ((i * 5 + j) % 13) as f64 - 6.0);
            let w: Vec<f64> = (0..n).map(|i| if i < n / 2 { 0.0 } else { (i % 3) as f64 }).collect();
            let weighted = |m: &Matrix| Matrix::from_fn(n, m.columns(), |i, j| w[i] * m[(i, j)]);
            // Whole numbers: sums are exact in any order.
            assert_eq!(a.weighted_gram(&w), a.transpose().product(&weighted(&a)));
            assert_eq!(a.weighted_product(&w, &b), a.transpose().product(&weighted(&b)));
            let c = Matrix::from_fn(q, p, |i, j| (i + 2 * j) as f64);
            assert_eq!(a.large_product(&c), a.product(&c));
        }
    }
}
