//! A noise on one block of data, kept by what it acts on.

use rijke_numerics::{Matrix, dot};

/// The structure S of a noise group in a block, S of the whole theory: its rows and columns that are not
/// zero. A noise of all growth rates acts on a few numbers of a large block, and what varies from one
/// installation to the next moves all of them along one direction.
#[derive(Clone, Debug)]
pub(crate) struct Acting {
    pub(crate) group: usize,
    /// The numbers of the block that it acts on, ascending.
    on: Vec<usize>,
    /// S among these.
    structure: Matrix,
    /// U with S = U U', where it has few columns.
    directions: Option<Matrix>,
}

/// A structure with this many rows for each of its directions is multiplied by these.
const ROWS_OF_A_DIRECTION: usize = 4;

impl Acting {
    pub(crate) fn new(group: usize, structure: &Matrix) -> Self {
        let n = structure.rows();
        let on: Vec<usize> = (0..n).filter(|&i| structure.row(i).iter().any(|s| *s != 0.0)).collect();
        let structure = structure.select(&on);
        let directions = directions(&structure, on.len() / ROWS_OF_A_DIRECTION);
        Self { group, on, structure, directions }
    }

    /// Adds `factor` S to a matrix of the block.
    pub(crate) fn add_to(&self, matrix: &mut Matrix, factor: f64) {
        for (a, &i) in self.on.iter().enumerate() {
            for (s, &j) in self.structure.row(a).iter().zip(&self.on) {
                matrix[(i, j)] += factor * s;
            }
        }
    }

    /// S x.
    pub(crate) fn times(&self, x: &[f64]) -> Vec<f64> {
        let own: Vec<f64> = self.on.iter().map(|&i| x[i]).collect();
        let mut product = vec![0.0; x.len()];
        for (a, &i) in self.on.iter().enumerate() {
            product[i] = dot(self.structure.row(a), &own);
        }
        product
    }

    /// tr S A of a symmetric A.
    pub(crate) fn trace_with(&self, matrix: &Matrix) -> f64 {
        let row = |(a, &i): (usize, &usize)| -> f64 {
            let of_block = matrix.row(i);
            self.structure.row(a).iter().zip(&self.on).map(|(s, &j)| s * of_block[j]).sum()
        };
        self.on.iter().enumerate().map(row).sum()
    }

    /// The rows of S A that are not zero, for a symmetric A. Cost: the width of A for each entry of S that is
    /// not zero, or for each number of its directions, twice.
    pub(crate) fn rows_times(&self, matrix: &Matrix) -> Matrix {
        let width = matrix.columns();
        let Some(u) = &self.directions else {
            let mut product = Matrix::zeros(self.on.len(), width);
            for (a, to) in product.as_mut_slice().chunks_exact_mut(width.max(1)).enumerate() {
                for (&s, &k) in self.structure.row(a).iter().zip(&self.on).filter(|(s, _)| **s != 0.0) {
                    to.iter_mut().zip(matrix.row(k)).for_each(|(to, from)| *to += s * from);
                }
            }
            return product;
        };
        let mut along = Matrix::zeros(u.columns(), width);
        for (a, &i) in self.on.iter().enumerate() {
            for (u, to) in u.row(a).iter().zip(along.as_mut_slice().chunks_exact_mut(width.max(1))) {
                to.iter_mut().zip(matrix.row(i)).for_each(|(to, from)| *to += u * from);
            }
        }
        u.product(&along)
    }

    /// tr S A T A, of the rows of S A and of those of T A.
    pub(crate) fn trace_of_product(&self, rows: &Matrix, other: &Self, others: &Matrix) -> f64 {
        let row = |(a, &i): (usize, &usize)| -> f64 {
            let own = rows.row(a);
            other.on.iter().enumerate().map(|(b, &j)| own[j] * others[(b, i)]).sum()
        };
        self.on.iter().enumerate().map(row).sum()
    }
}

/// U with S = U U' to rounding, of at most so many columns: the factor of Cholesky with pivots. None where
/// more are needed.
fn directions(structure: &Matrix, most: usize) -> Option<Matrix> {
    let n = structure.rows();
    let mut left: Vec<f64> = (0..n).map(|i| structure[(i, i)]).collect();
    let least = left.iter().copied().fold(0.0, f64::max) * n as f64 * f64::EPSILON;
    let mut columns: Vec<Vec<f64>> = Vec::new();
    loop {
        let pivot = (0..n).max_by(|&i, &j| left[i].total_cmp(&left[j]))?;
        if left[pivot] <= least {
            return Some(Matrix::from_fn(n, columns.len(), |i, k| columns[k][i]));
        }
        if columns.len() == most {
            return None;
        }
        let root = left[pivot].sqrt();
        let column: Vec<f64> = (0..n)
            .map(|i| {
                let known: f64 = columns.iter().map(|c| c[i] * c[pivot]).sum();
                (structure[(i, pivot)] - known) / root
            })
            .collect();
        left.iter_mut().zip(&column).for_each(|(left, c)| *left -= c * c);
        columns.push(column);
    }
}
