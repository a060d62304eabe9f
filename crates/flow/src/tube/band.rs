//! A matrix with two diagonals on either side, factorised without pivoting.

/// Rows of five entries, columns i - 2 to i + 2. The wall rows are diagonally dominant and the gas rows
/// triangular, so no pivoting is needed.
#[derive(Clone, Debug)]
pub(crate) struct Band {
    rows: Vec<[f64; 5]>,
}

impl Band {
    pub(crate) fn zeros(size: usize) -> Self {
        Self { rows: vec![[0.0; 5]; size] }
    }

    pub(crate) fn add(&mut self, row: usize, column: usize, value: f64) {
        self.rows[row][column + 2 - row] += value;
    }

    /// Replaces the matrix by its factors; false if a pivot is zero or not a number.
    pub(crate) fn factorise(&mut self) -> bool {
        let n = self.rows.len();
        for k in 0..n {
            let pivot = self.rows[k];
            if !pivot[2].is_normal() {
                return false;
            }
            for below in 1..=2.min(n - 1 - k) {
                let row = &mut self.rows[k + below];
                let factor = row[2 - below] / pivot[2];
                row[2 - below] = factor;
                for right in 1..=2 {
                    row[2 - below + right] -= factor * pivot[2 + right];
                }
            }
        }
        true
    }

    /// Solves with the factors, in place.
    pub(crate) fn solve(&self, x: &mut [f64]) {
        let n = x.len();
        for i in 0..n {
            for back in 1..=2.min(i) {
                x[i] -= self.rows[i][2 - back] * x[i - back];
            }
        }
        for i in (0..n).rev() {
            for ahead in 1..=2.min(n - 1 - i) {
                x[i] -= self.rows[i][2 + ahead] * x[i + ahead];
            }
            x[i] /= self.rows[i][2];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rijke_numerics::{Matrix, lu_solve};

    #[test]
    fn oracle_dense_lu() {
        let n = 9;
        let entry = |i: usize, j: usize| {
            if i == j {
                5.0
            } else if i.abs_diff(j) <= 2 {
                ((3 * i + 7 * j) % 5) as f64 - 2.0
            } else {
                0.0
            }
        };
        let mut band = Band::zeros(n);
        for i in 0..n {
            for j in i.saturating_sub(2)..(i + 3).min(n) {
                band.add(i, j, entry(i, j));
            }
        }
        let b: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let mut x = b.clone();
        assert!(band.factorise());
        band.solve(&mut x);
        let dense = lu_solve(&Matrix::from_fn(n, n, entry), &b).unwrap();
        for (x, d) in x.iter().zip(dense) {
            assert!((x - d).abs() < 1e-13);
        }
        assert!(!Band::zeros(2).factorise());
    }
}
