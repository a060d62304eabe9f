//! A noise on one block of data, kept by what it acts on.

use rijke_numerics::{Matrix, dot};

/// The structure S of a noise group in a block, by its rows and columns that are not zero. A noise of all
/// growth rates acts on a few numbers of a large block, and what varies from one installation to the next
/// moves all of them along one direction.
#[derive(Clone, Debug)]
pub(crate) struct BlockNoise {
    pub(crate) group: usize,
    /// The numbers of the block that it acts on, ascending.
    on: Vec<usize>,
    /// S among these.
    structure: Matrix,
    /// U with S = U U', where it has few columns.
    directions: Option<Matrix>,
    /// The entries of S that are not zero: the row among `on`, the column in the block, and the entry; none
    /// where they are many.
    entries: Option<Vec<(usize, usize, f64)>>,
}

/// A structure with this many rows for each of its directions is multiplied by these.
const ROWS_OF_A_DIRECTION: usize = 4;
/// Of so many entries one at most is not zero in a structure that is multiplied entry by entry.
const FEW: usize = 4;

impl BlockNoise {
    pub(crate) fn new(group: usize, structure: &Matrix) -> Self {
        let n = structure.rows();
        let on: Vec<usize> = (0..n).filter(|&i| structure.row(i).iter().any(|s| *s != 0.0)).collect();
        let structure = structure.select(&on);
        let directions = directions(&structure, on.len() / ROWS_OF_A_DIRECTION);
        let each = (0..on.len()).flat_map(|a| (0..on.len()).map(move |b| (a, b)));
        let entries: Vec<(usize, usize, f64)> = each
            .filter(|&place| structure[place] != 0.0)
            .map(|(a, b)| (a, on[b], structure[(a, b)]))
            .collect();
        let entries = Some(entries).filter(|entries| FEW * entries.len() <= on.len().pow(2));
        Self { group, on, structure, directions, entries }
    }

    /// Adds `factor` S to a matrix of the block.
    pub(crate) fn add_to(&self, matrix: &mut Matrix, factor: f64) {
        if let Some(entries) = &self.entries {
            entries.iter().for_each(|&(a, j, s)| matrix[(self.on[a], j)] += factor * s);
            return;
        }
        for (a, &i) in self.on.iter().enumerate() {
            for (s, &j) in self.structure.row(a).iter().zip(&self.on) {
                matrix[(i, j)] += factor * s;
            }
        }
    }

    /// S x.
    pub(crate) fn times(&self, x: &[f64]) -> Vec<f64> {
        if let Some(entries) = &self.entries {
            let mut product = vec![0.0; x.len()];
            entries.iter().for_each(|&(a, j, s)| product[self.on[a]] += s * x[j]);
            return product;
        }
        let own: Vec<f64> = self.on.iter().map(|&i| x[i]).collect();
        let mut product = vec![0.0; x.len()];
        for (a, &i) in self.on.iter().enumerate() {
            product[i] = dot(self.structure.row(a), &own);
        }
        product
    }

    /// tr S A of a symmetric A.
    pub(crate) fn trace_with(&self, matrix: &Matrix) -> f64 {
        if let Some(entries) = &self.entries {
            return entries.iter().map(|&(a, j, s)| s * matrix[(self.on[a], j)]).sum();
        }
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
            let Some(entries) = &self.entries else {
                let own = Matrix::from_fn(self.on.len(), width, |a, j| matrix[(self.on[a], j)]);
                return self.structure.large_product(&own);
            };
            let mut product = Matrix::zeros(self.on.len(), width);
            for &(a, j, s) in entries {
                let to = &mut product.as_mut_slice()[a * width..(a + 1) * width];
                to.iter_mut().zip(matrix.row(j)).for_each(|(to, from)| *to += s * from);
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
/// more are needed, or S has negative eigenvalues.
fn directions(structure: &Matrix, most: usize) -> Option<Matrix> {
    let n = structure.rows();
    let mut left: Vec<f64> = (0..n).map(|i| structure[(i, i)]).collect();
    let least = left.iter().copied().fold(0.0, f64::max) * n as f64 * f64::EPSILON;
    let mut columns: Vec<Vec<f64>> = Vec::new();
    loop {
        let pivot = (0..n).max_by(|&i, &j| left[i].total_cmp(&left[j]))?;
        if left[pivot] <= least {
            let u = Matrix::from_fn(n, columns.len(), |i, k| columns[k][i]);
            let is_near = |i: usize, j: usize| {
                let found: f64 = u.row(i).iter().zip(u.row(j)).map(|(a, b)| a * b).sum();
                (found - structure[(i, j)]).abs() <= 2.0 * least
            };
            return (0..n).all(|i| (0..=i).all(|j| is_near(i, j))).then_some(u);
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

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// S among 3 of 5 numbers, and what multiplies it.
    fn whole(structure: [[f64; 3]; 3]) -> (Matrix, Matrix) {
        let on = [0, 2, 3];
        let place = |i: usize| on.iter().position(|k| *k == i);
        let s = Matrix::from_fn(5, 5, |i, j| match (place(i), place(j)) {
            (Some(a), Some(b)) => structure[a][b],
            _ => 0.0,
        });
        let a = Matrix::from_fn(5, 5, |i, j| 1.0 / (1.0 + (i + j) as f64) + f64::from(u8::from(i == j)));
        (s, a)
    }

    #[test]
    fn exact_products_are_those_of_whole_matrices() {
        let few = [[2.0, 0.0, 0.0], [0.0, 1.0, 0.5], [0.0, 0.5, 3.0]];
        // Not positive definite: its diagonal tells nothing of it.
        let turned = [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1e-3]];
        let (s, a) = whole(few);
        let (t, _) = whole(turned);
        let [one, other] = [&s, &t].map(|s| BlockNoise::new(0, s));
        let mut sum = a.clone();
        other.add_to(&mut sum, 2.0);
        assert_eq!(sum, a.plus(2.0, &t));
        let x = [1.0, -2.0, 0.5, 3.0, 1.0];
        assert_eq!(one.times(&x), s.times(&x));
        let trace = |m: &Matrix| (0..5).map(|i| m[(i, i)]).sum::<f64>();
        assert_relative_eq!(one.trace_with(&a), trace(&s.product(&a)), max_relative = 1e-14);
        let both = one.trace_of_product(&one.rows_times(&a), &other, &other.rows_times(&a));
        let expected = trace(&s.product(&a).product(&t).product(&a));
        assert_relative_eq!(both, expected, max_relative = 1e-13);
    }

    #[test]
    fn exact_directions_are_those_that_make_the_structure() {
        let v: Vec<f64> = (0..12).map(|k| 1.0 + k as f64).collect();
        let one = Matrix::from_fn(12, 12, |i, j| v[i] * v[j]);
        let u = directions(&one, 3).unwrap();
        assert_eq!(u.columns(), 1);
        let again = u.product(&u.transpose());
        for (a, b) in again.as_slice().iter().zip(one.as_slice()) {
            assert_relative_eq!(a, b, max_relative = 1e-14);
        }
        assert!(directions(&Matrix::identity(12), 3).is_none());
        // Of a diagonal of zeros only zero is such a product.
        let mut exchanged = Matrix::zeros(12, 12);
        (exchanged[(0, 1)], exchanged[(1, 0)]) = (1.0, 1.0);
        assert!(directions(&exchanged, 3).is_none());
    }
}
