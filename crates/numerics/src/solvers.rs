//! Linear systems, eigenvalues and least squares of small dense matrices.

use crate::C64;
use crate::dense::{DenseError, Matrix, shape};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

/// Standard deviations of a least-squares fit: the square roots of the diagonal of (A'A)^-1, for a tall `a`.
///
/// By Householder QR, so the loss of digits is that of `a`, not of its square as with a Cholesky factor of
/// A'A.
///
/// # Errors
/// [`DenseError::Singular`] if the columns of `a` are dependent to rounding, or hold a NaN.
pub fn least_squares_sd(a: &Matrix) -> Result<Vec<f64>, DenseError> {
    let n = a.columns();
    let singular = DenseError::Singular { size: n };
    if a.rows() < n || a.as_slice().iter().any(|x| !x.is_finite()) {
        return Err(singular);
    }
    let factor = a.to_faer().qr();
    let r = factor.thin_R();
    // Row sums of squares of R^-1, column by column of it, from the bottom up.
    let mut sums = vec![0.0; n];
    for j in 0..n {
        let mut column = vec![0.0; n];
        for i in (0..=j).rev() {
            let known: f64 = (i + 1..=j).map(|k| r[(i, k)] * column[k]).sum();
            column[i] = (f64::from(u8::from(i == j)) - known) / r[(i, i)];
            sums[i] += column[i] * column[i];
        }
    }
    if sums.iter().all(|s| s.is_finite()) {
        Ok(sums.into_iter().map(f64::sqrt).collect())
    } else {
        Err(singular)
    }
}

/// The unit vector x for which |A x| is least: the right singular vector of the smallest singular value.
///
/// # Errors
/// [`DenseError::NoEigenvalues`] as for a NaN; [`DenseError::Singular`] if x is not unique, having too few
/// rows.
pub fn least_direction(a: &Matrix) -> Result<Vec<f64>, DenseError> {
    let n = a.columns();
    if a.rows() < n || n == 0 {
        return Err(DenseError::Singular { size: n });
    } else if a.as_slice().iter().any(|x| !x.is_finite()) {
        return Err(DenseError::NoEigenvalues { size: n });
    }
    let svd = a.to_faer().thin_svd().map_err(|_| DenseError::NoEigenvalues { size: n })?;
    Ok((0..n).map(|i| svd.V()[(i, n - 1)]).collect())
}

/// Solution of A x = b for a general square `a`, by LU with partial pivoting.
///
/// # Errors
/// [`DenseError::Singular`] if the solution is not finite, [`DenseError::Shape`] unless `a` is square and `b`
/// has a number for each row.
pub fn lu_solve(a: &Matrix, b: &[f64]) -> Result<Vec<f64>, DenseError> {
    shape("the right-hand side", b.len(), a.square()?)?;
    let x = a.to_faer().partial_piv_lu().solve(Mat::from_fn(b.len(), 1, |i, _| b[i]));
    let x: Vec<f64> = (0..b.len()).map(|i| x[(i, 0)]).collect();
    if x.iter().all(|v| v.is_finite()) { Ok(x) } else { Err(DenseError::Singular { size: a.rows() }) }
}

/// Solution of A x = b for a complex square matrix given row by row.
///
/// # Errors
/// [`DenseError::Singular`] if the solution is not finite, [`DenseError::Shape`] unless `a` has as many
/// numbers as a square matrix with a row for each of `b`.
pub fn complex_lu_solve(a: &[C64], b: &[C64]) -> Result<Vec<C64>, DenseError> {
    let n = b.len();
    shape("the matrix", a.len(), n * n)?;
    let x = Mat::from_fn(n, n, |i, j| a[i * n + j]).partial_piv_lu().solve(Mat::from_fn(n, 1, |i, _| b[i]));
    let x: Vec<C64> = (0..n).map(|i| x[(i, 0)]).collect();
    if x.iter().all(|v| v.is_finite()) { Ok(x) } else { Err(DenseError::Singular { size: n }) }
}

/// Eigenvalues of a complex square matrix of `size` rows, given row by row; in no particular order.
///
/// # Errors
/// [`DenseError::NoEigenvalues`] if the iteration fails, as it does for a NaN; [`DenseError::Shape`] unless
/// `a` has the square of `size` numbers.
pub fn complex_eigenvalues(a: &[C64], size: usize) -> Result<Vec<C64>, DenseError> {
    shape("the matrix", a.len(), size.saturating_mul(size))?;
    let failed = DenseError::NoEigenvalues { size };
    if a.iter().any(|z| !z.is_finite()) {
        return Err(failed);
    }
    if size == 0 {
        return Ok(Vec::new());
    }
    Mat::from_fn(size, size, |i, j| a[i * size + j]).eigenvalues().map_err(|_| failed)
}

/// The principal directions of a covariance, the one with the largest variance first: variances, those below
/// zero by rounding as zero, and unit vectors.
///
/// # Errors
/// As [`symmetric_eigen`].
pub fn principal_directions(covariance: &Matrix) -> Result<Vec<(f64, Vec<f64>)>, DenseError> {
    let (values, vectors) = symmetric_eigen(covariance)?;
    let n = values.len();
    let direction = |k: usize| (values[k].max(0.0), (0..n).map(|i| vectors[(i, k)]).collect());
    Ok((0..n).rev().map(direction).collect())
}

/// Eigenvalues in ascending order and orthonormal eigenvectors (as columns) of a symmetric matrix.
///
/// # Errors
/// [`DenseError::NoEigenvalues`] if the iteration fails, as it does for a NaN; [`DenseError::Shape`] unless
/// `a` is square. Only its lower triangle is read.
pub fn symmetric_eigen(a: &Matrix) -> Result<(Vec<f64>, Matrix), DenseError> {
    a.square()?;
    let failed = DenseError::NoEigenvalues { size: a.rows() };
    if a.as_slice().iter().any(|x| !x.is_finite()) {
        return Err(failed);
    }
    if a.rows() == 0 {
        return Ok((Vec::new(), a.clone()));
    }
    let eigen = a.to_faer().self_adjoint_eigen(Side::Lower).map_err(|_| failed)?;
    let (values, vectors) = (eigen.S(), eigen.U());
    let values = (0..a.rows()).map(|i| values.column_vector()[i]).collect();
    Ok((values, Matrix::from_fn(a.rows(), a.rows(), |i, j| vectors[(i, j)])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Cholesky;
    use approx::assert_relative_eq;
    use std::panic::catch_unwind;

    fn spd() -> Matrix {
        let b = Matrix::from_fn(4, 4, |i, j| ((3 * i + 5 * j) % 7) as f64 - 2.0);
        b.product(&b.transpose()).plus(1.0, &Matrix::identity(4))
    }

    #[test]
    fn exact_cholesky_rebuilds_solves_and_whitens() {
        let a = spd();
        let factor = Cholesky::new(&a).unwrap();
        let rebuilt = factor.lower().product(&factor.lower().transpose());
        let x = [0.3, -1.0, 2.0, 0.7];
        let back = factor.solve(&a.times(&x));
        let inverse = factor.inverse();
        for i in 0..4 {
            assert_relative_eq!(back[i], x[i], epsilon = 1e-12);
            for j in 0..4 {
                assert_relative_eq!(rebuilt[(i, j)], a[(i, j)], epsilon = 1e-12);
            }
        }
        let white = factor.whiten(&x);
        assert_relative_eq!(white.iter().map(|v| v * v).sum::<f64>(), inverse.quadratic(&x), epsilon = 1e-12);
        let (values, _) = symmetric_eigen(&a).unwrap();
        assert_relative_eq!(values.iter().map(|v| v.ln()).sum::<f64>(), factor.ln_det(), epsilon = 1e-12);
    }

    #[test]
    fn exact_least_squares_sd_where_the_normal_matrix_is_singular() {
        // Columns (1, e, 0) and (1, 0, e): A'A = [[1 + e^2, 1], [1, 1 + e^2]], whose inverse has the diagonal
        // (1 + e^2) / (2 e^2 + e^4); with e = 1e-9 the matrix itself is singular in double precision.
        let e = 1e-9;
        let a = Matrix::from_fn(3, 2, |i, j| if i == 0 { 1.0 } else { e * f64::from(u8::from(i == j + 1)) });
        assert!(Cholesky::new(&a.transpose().product(&a)).is_err());
        for sd in least_squares_sd(&a).unwrap() {
            assert_relative_eq!(sd, 0.5_f64.sqrt() / e, max_relative = 1e-6);
        }
        assert!(least_squares_sd(&Matrix::from_fn(3, 2, |_, _| 0.0)).is_err());
    }

    #[test]
    fn exact_least_direction_keeps_digits_that_the_normal_matrix_loses() {
        // Columns (1, 1, e), (1, 1, -e), (0, 1, 0): the smallest singular value, about e, belongs to (1, -1,
        // 0).
        let e = 1e-10;
        let a =
            Matrix::from_fn(4, 3, |i, j| [[1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [e, -e, 0.0], [0.0; 3]][i][j]);
        let x = least_direction(&a).unwrap();
        assert_relative_eq!(x[0].abs(), 0.5_f64.sqrt(), epsilon = 1e-12);
        assert_relative_eq!(x[0], -x[1], epsilon = 1e-12);
        assert_relative_eq!(x[2], 0.0, epsilon = 1e-12);
        assert!(least_direction(&a.transpose()).is_err());
    }

    #[test]
    fn exact_complex_eigenvalues_of_a_companion_matrix() {
        // z^2 - (3 + i) z + (2 + 2i) has the roots 2 and 1 + i.
        let a = [C64::new(3.0, 1.0), C64::new(-2.0, -2.0), C64::ONE, C64::ZERO];
        let mut roots = complex_eigenvalues(&a, 2).unwrap();
        roots.sort_by(|p, q| p.re.total_cmp(&q.re));
        assert_relative_eq!((roots[0] - C64::new(1.0, 1.0)).norm(), 0.0, epsilon = 1e-13);
        assert_relative_eq!((roots[1] - C64::new(2.0, 0.0)).norm(), 0.0, epsilon = 1e-13);
    }

    #[test]
    fn message_wrong_sizes_are_refused() {
        let a = Matrix::from_fn(2, 3, |i, j| (3 * i + j) as f64);
        let (two, complex) = (Matrix::identity(2), [C64::ONE; 6]);
        let wrong = |error: DenseError| assert!(matches!(error, DenseError::Shape { .. }), "{error}");
        wrong(lu_solve(&a, &[1.0, 2.0]).unwrap_err());
        wrong(lu_solve(&two, &[1.0; 3]).unwrap_err());
        wrong(symmetric_eigen(&a).unwrap_err());
        wrong(Cholesky::new(&a).unwrap_err());
        wrong(complex_lu_solve(&complex, &[C64::ONE; 2]).unwrap_err());
        wrong(complex_eigenvalues(&complex, 2).unwrap_err());
        // Methods without an error panic, and give no number.
        let panics = |what: &str, wrong: &(dyn Fn() + std::panic::RefUnwindSafe)| {
            assert!(catch_unwind(wrong).is_err(), "{what}");
        };
        panics("plus", &|| drop(a.plus(1.0, &Matrix::zeros(1, 1))));
        panics("product", &|| drop(a.product(&a)));
        panics("large product", &|| drop(a.large_product(&a)));
        panics("times", &|| drop(a.times(&[1.0])));
        panics("times more", &|| drop(a.times(&[1.0; 9])));
        panics("quadratic", &|| assert!(a.quadratic(&[1.0; 3]) > f64::MIN));
        panics("outer", &|| a.clone().add_outer(&[1.0; 2]));
        panics("index", &|| assert!(a[(0, 5)] > f64::MIN));
        panics("gram", &|| drop(a.weighted_gram(&[1.0])));
        panics("weighted product", &|| drop(a.weighted_product(&[1.0; 2], &Matrix::zeros(1, 1))));
        let factor = Cholesky::new(&two).unwrap();
        panics("solve", &|| drop(factor.solve(&[1.0])));
        panics("whiten", &|| drop(factor.whiten(&[1.0; 3])));
    }

    #[test]
    fn exact_singular_and_indefinite_are_errors() {
        let flat = Matrix::from_fn(2, 2, |_, _| 1.0);
        assert!(matches!(lu_solve(&flat, &[1.0, 2.0]), Err(DenseError::Singular { size: 2 })));
        let indefinite = Matrix::diagonal(&[1.0, -1.0]);
        assert!(matches!(Cholesky::new(&indefinite), Err(DenseError::NotPositiveDefinite { pivot: 1, .. })));
        assert!(symmetric_eigen(&Matrix::diagonal(&[1.0, f64::NAN])).is_err());
        assert!(principal_directions(&Matrix::zeros(2, 3)).is_err());
        let directions = principal_directions(&Matrix::diagonal(&[2.0, -1e-18, 5.0])).unwrap();
        let variances: Vec<f64> = directions.iter().map(|d| d.0).collect();
        assert_eq!(variances, [5.0, 2.0, 0.0]);
        assert_eq!(directions[0].1.iter().map(|v| v.abs()).collect::<Vec<_>>(), [0.0, 0.0, 1.0]);
    }

    #[test]
    fn exact_nothing_has_no_eigenvalues() {
        let nothing = Matrix::zeros(0, 0);
        assert!(symmetric_eigen(&nothing).unwrap().0.is_empty());
        assert!(principal_directions(&nothing).unwrap().is_empty());
        assert!(complex_eigenvalues(&[], 0).unwrap().is_empty());
    }
}
