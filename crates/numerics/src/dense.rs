//! Small dense matrices. With `cholesky`, `product` and `solvers`, the only files of the workspace that name
//! the linear-algebra library.

use faer::Mat;
use std::ops::{Index, IndexMut};

/// A real matrix, row-major, indexed `m[(row, column)]`.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Matrix {
    rows: usize,
    columns: usize,
    data: Vec<f64>,
}

/// Why a solve has no answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DenseError {
    /// A Cholesky factor does not exist: the matrix is not positive definite, or holds a NaN.
    #[error("the {size} x {size} matrix is not positive definite: pivot {pivot} is not positive")]
    NotPositiveDefinite {
        /// Number of rows.
        size: usize,
        /// Index of the first pivot that is not positive.
        pivot: usize,
    },
    /// The matrix is singular to working precision, or holds a NaN.
    #[error("the {size} x {size} matrix is singular to working precision")]
    Singular {
        /// Number of rows.
        size: usize,
    },
    /// The sizes do not fit.
    #[error(
        "{what} has {found} numbers instead of {expected}: give a square matrix and one number for each row"
    )]
    Shape {
        /// What does not fit.
        what: &'static str,
        /// How many numbers it has.
        found: usize,
        /// How many it must have.
        expected: usize,
    },
    /// An eigenvalue iteration did not converge.
    #[error("the eigenvalue iteration of a {size} x {size} matrix did not converge")]
    NoEigenvalues {
        /// Number of rows.
        size: usize,
    },
}

impl Matrix {
    /// All zeros.
    #[must_use]
    pub fn zeros(rows: usize, columns: usize) -> Self {
        Self { rows, columns, data: vec![0.0; rows * columns] }
    }

    /// Ones on the diagonal.
    #[must_use]
    pub fn identity(size: usize) -> Self {
        Self::from_fn(size, size, |i, j| f64::from(u8::from(i == j)))
    }

    /// The given values on the diagonal.
    #[must_use]
    pub fn diagonal(values: &[f64]) -> Self {
        let mut m = Self::zeros(values.len(), values.len());
        for (i, &v) in values.iter().enumerate() {
            m[(i, i)] = v;
        }
        m
    }

    /// Element by element.
    #[must_use]
    pub fn from_fn(rows: usize, columns: usize, f: impl Fn(usize, usize) -> f64) -> Self {
        let mut data = Vec::with_capacity(rows * columns);
        for i in 0..rows {
            data.extend((0..columns).map(|j| f(i, j)));
        }
        Self { rows, columns, data }
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// The elements, row by row.
    #[must_use]
    pub fn as_slice(&self) -> &[f64] {
        &self.data
    }

    /// The elements, row by row.
    pub fn as_mut_slice(&mut self) -> &mut [f64] {
        &mut self.data
    }

    /// Row `i`.
    #[must_use]
    pub fn row(&self, i: usize) -> &[f64] {
        &self.data[i * self.columns..(i + 1) * self.columns]
    }

    /// The transpose.
    #[must_use]
    pub fn transpose(&self) -> Self {
        Self::from_fn(self.columns, self.rows, |i, j| self[(j, i)])
    }

    /// self * other.
    ///
    /// # Panics
    /// Unless `other` has as many rows as this has columns.
    #[must_use]
    pub fn product(&self, other: &Self) -> Self {
        assert_eq!(self.columns, other.rows, "a product needs as many rows as columns");
        let mut out = Self::zeros(self.rows, other.columns);
        for i in 0..self.rows {
            for (k, &a) in self.row(i).iter().enumerate() {
                let target = &mut out.data[i * other.columns..(i + 1) * other.columns];
                for (o, b) in target.iter_mut().zip(other.row(k)) {
                    *o += a * b;
                }
            }
        }
        out
    }

    /// The trace of the product with another matrix.
    #[must_use]
    pub fn trace_of_product(&self, other: &Self) -> f64 {
        let row = |i: usize| -> f64 { (0..self.columns).map(|j| self[(i, j)] * other[(j, i)]).sum() };
        (0..self.rows).map(row).sum()
    }

    /// self * vector.
    ///
    /// # Panics
    /// Unless `vector` has as many numbers as this has columns.
    #[must_use]
    pub fn times(&self, vector: &[f64]) -> Vec<f64> {
        assert_eq!(self.columns, vector.len(), "a vector needs one number for each column");
        (0..self.rows).map(|i| dot(self.row(i), vector)).collect()
    }

    /// vector' * self * vector.
    ///
    /// # Panics
    /// Unless this is square, of the size of `vector`.
    #[must_use]
    pub fn quadratic(&self, vector: &[f64]) -> f64 {
        assert_eq!(self.rows, vector.len(), "a quadratic form needs one number for each row");
        dot(&self.times(vector), vector)
    }

    /// self + factor * other.
    ///
    /// # Panics
    /// Unless both have the same size.
    #[must_use]
    pub fn plus(&self, factor: f64, other: &Self) -> Self {
        assert_eq!((self.rows, self.columns), (other.rows, other.columns), "a sum needs equal sizes");
        let data = self.data.iter().zip(&other.data).map(|(a, b)| a + factor * b).collect();
        Self { data, ..*self }
    }

    /// Adds v v' to a square matrix of the size of `v`.
    ///
    /// # Panics
    /// Unless this is one.
    pub fn add_outer(&mut self, v: &[f64]) {
        assert_eq!((self.rows, self.columns), (v.len(), v.len()), "v v' needs a square matrix of its size");
        for (row, a) in self.data.chunks_exact_mut(v.len().max(1)).zip(v) {
            for (to, b) in row.iter_mut().zip(v) {
                *to += a * b;
            }
        }
    }

    /// The rows and columns named in `keep`, in that order.
    #[must_use]
    pub fn select(&self, keep: &[usize]) -> Self {
        Self::from_fn(keep.len(), keep.len(), |i, j| self[(keep[i], keep[j])])
    }

    pub(crate) fn to_faer(&self) -> Mat<f64> {
        Mat::from_fn(self.rows, self.columns, |i, j| self[(i, j)])
    }

    /// Fails unless this is square.
    pub(crate) fn square(&self) -> Result<usize, DenseError> {
        let (expected, found) = (self.rows * self.rows, self.data.len());
        shape("a square matrix", found, expected).map(|()| self.rows)
    }
}

/// Fails if there are not as many numbers as there must be.
pub(crate) fn shape(what: &'static str, found: usize, expected: usize) -> Result<(), DenseError> {
    if found == expected { Ok(()) } else { Err(DenseError::Shape { what, found, expected }) }
}

impl Index<(usize, usize)> for Matrix {
    type Output = f64;
    #[inline]
    fn index(&self, (row, column): (usize, usize)) -> &f64 {
        assert!(column < self.columns, "there is no column {column}: the matrix has {}", self.columns);
        &self.data[row * self.columns + column]
    }
}

impl IndexMut<(usize, usize)> for Matrix {
    #[inline]
    fn index_mut(&mut self, (row, column): (usize, usize)) -> &mut f64 {
        assert!(column < self.columns, "there is no column {column}: the matrix has {}", self.columns);
        &mut self.data[row * self.columns + column]
    }
}

/// Linear interpolation in a table whose places ascend; constant beyond its ends.
///
/// # Panics
/// With fewer than two places, or fewer values than places.
#[must_use]
pub fn interpolate(places: &[f64], values: &[f64], x: f64) -> f64 {
    let upper = places.partition_point(|&p| p <= x).clamp(1, places.len() - 1);
    let (x0, x1) = (places[upper - 1], places[upper]);
    let share = ((x - x0) / (x1 - x0)).clamp(0.0, 1.0);
    values[upper - 1] + share * (values[upper] - values[upper - 1])
}

/// The scalar product; of two lengths, over the shorter one.
#[must_use]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let ((a, rest), (b, other)) = (a[..n].as_chunks::<LANES>(), b[..n].as_chunks::<LANES>());
    let tail = rest.iter().zip(other).map(|(x, y)| x * y).sum::<f64>();
    if a.is_empty() {
        return tail;
    }
    let mut sums = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        for k in 0..LANES {
            sums[k] += a[k] * b[k];
        }
    }
    sums.iter().sum::<f64>() + tail
}

/// Sums that are independent of each other: one alone waits for its last addition.
const LANES: usize = 8;
