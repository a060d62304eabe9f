//! Means and anomalies of the rows of a matrix.

use rijke_numerics::Matrix;

/// Mean of every column.
pub(super) fn column_means(matrix: &Matrix) -> Vec<f64> {
    let mut mean = vec![0.0; matrix.columns()];
    for i in 0..matrix.rows() {
        for (m, v) in mean.iter_mut().zip(matrix.row(i)) {
            *m += v;
        }
    }
    mean.iter_mut().for_each(|m| *m /= matrix.rows() as f64);
    mean
}

/// Mean of every column, and the matrix without it.
pub(super) fn centred(matrix: &Matrix) -> (Vec<f64>, Matrix) {
    let mean = column_means(matrix);
    let mut anomalies = matrix.clone();
    for row in anomalies.as_mut_slice().chunks_mut(mean.len().max(1)) {
        for (a, m) in row.iter_mut().zip(&mean) {
            *a -= m;
        }
    }
    (mean, anomalies)
}
