//! Random draws that leave the moments of an ensemble alone.

use super::EnsembleError;
use super::moments::centred;
use rand_distr::{Distribution, StandardNormal};
use rijke_numerics::{Matrix, Stream};

/// Random forcing with exact sample moments: `against.rows()` draws of `variances.len()` independent
/// variables, with zero mean, the given variances, no sample correlation with each other, and none with the
/// columns of `against` (the anomalies of whatever the forcing must not pretend to know about).
///
/// Without this, chance correlations between fresh noise and static parameters are exploited at every
/// analysis; in a linear-Gaussian test with 6 parameters and 2000 analyses the 2 sd coverage then falls from
/// 95 % to about 40 %. Columns of `against` that depend on the others to `tolerance` (relative) are left out.
///
/// # Errors
/// [`EnsembleError::TooFewMembers`] with fewer members than 1 + the independent columns + the variances;
/// [`EnsembleError::Variance`] and [`EnsembleError::NotFinite`] for numbers that are none.
pub fn orthogonal_forcing(
    against: &Matrix,
    variances: &[f64],
    tolerance: f64,
    stream: &mut Stream,
) -> Result<Matrix, EnsembleError> {
    let members = against.rows();
    let negative = |v: &f64| !(*v >= 0.0 && v.is_finite());
    if let Some(place) = variances.iter().position(negative) {
        return Err(EnsembleError::Variance { place, value: variances[place] });
    }
    if let Some(k) = against.as_slice().iter().position(|v| !v.is_finite()) {
        let columns = against.columns();
        return Err(EnsembleError::NotFinite { member: k / columns, variable: k % columns });
    }
    let mut basis: Vec<Vec<f64>> = vec![vec![1.0 / (members as f64).sqrt(); members]];
    for j in 0..against.columns() {
        let column: Vec<f64> = (0..members).map(|i| against[(i, j)]).collect();
        add_direction(&mut basis, column, tolerance);
    }
    let need = basis.len() + variances.len();
    if need > members {
        return Err(EnsembleError::TooFewMembers { have: members, need });
    }
    let mut draws = Matrix::zeros(members, variances.len());
    for (k, variance) in variances.iter().enumerate() {
        // A draw lies in the span of what is there already with probability zero, up to rounding: draw again
        // then.
        let known = basis.len();
        while basis.len() == known {
            let draw = StandardNormal.sample_iter(&mut *stream).take(members).collect();
            add_direction(&mut basis, draw, 1e-6);
        }
        let scale = (variance * (members as f64 - 1.0)).sqrt();
        for i in 0..members {
            draws[(i, k)] = scale * basis[known][i];
        }
    }
    Ok(draws)
}

/// Gram-Schmidt, twice for orthogonality to rounding; nothing is added if less than `tolerance` is new.
fn add_direction(basis: &mut Vec<Vec<f64>>, mut column: Vec<f64>, tolerance: f64) {
    let norm = |c: &[f64]| c.iter().map(|v| v * v).sum::<f64>().sqrt();
    let before = norm(&column);
    for _ in 0..2 {
        for b in basis.iter() {
            let along: f64 = b.iter().zip(&column).map(|(x, y)| x * y).sum();
            column.iter_mut().zip(b).for_each(|(c, b)| *c -= along * b);
        }
    }
    let after = norm(&column);
    if after > tolerance * before {
        column.iter_mut().for_each(|c| *c /= after);
        basis.push(column);
    }
}

/// Standard normal numbers.
pub(super) fn normal_matrix(rows: usize, columns: usize, stream: &mut Stream) -> Matrix {
    let mut matrix = Matrix::zeros(rows, columns);
    matrix.as_mut_slice().iter_mut().for_each(|v| *v = StandardNormal.sample(stream));
    matrix
}

/// Standard normal numbers with the mean over the members removed and the variance restored in expectation.
pub(super) fn centred_normal(members: usize, columns: usize, stream: &mut Stream) -> Matrix {
    let (_, mut noise) = centred(&normal_matrix(members, columns, stream));
    let factor = (members as f64 / (members as f64 - 1.0)).sqrt();
    noise.as_mut_slice().iter_mut().for_each(|v| *v *= factor);
    noise
}

/// Mean of the rows `survivors` plus a standard normal combination of their anomalies over sqrt(n - 1).
pub(super) fn draw_from(members: &Matrix, survivors: &[usize], stream: &mut Stream) -> Vec<f64> {
    let rows = Matrix::from_fn(survivors.len(), members.columns(), |i, j| members[(survivors[i], j)]);
    let (mut drawn, anomalies) = centred(&rows);
    let scale = 1.0 / (survivors.len() as f64 - 1.0).max(1.0).sqrt();
    for i in 0..anomalies.rows() {
        let weight: f64 = StandardNormal.sample(stream);
        drawn.iter_mut().zip(anomalies.row(i)).for_each(|(d, a)| *d += scale * weight * a);
    }
    drawn
}

/// A random orthogonal matrix that maps the vector of ones to itself: a random rotation of the other N - 1
/// directions (Gram-Schmidt of normal draws, hence uniform over the orthogonal group) seen from two
/// orthonormal bases.
pub(super) fn mean_preserving_rotation(members: usize, stream: &mut Stream) -> Matrix {
    let basis = |stream: &mut Stream| {
        let mut basis: Vec<Vec<f64>> = vec![vec![1.0 / (members as f64).sqrt(); members]];
        while basis.len() < members {
            let draw = StandardNormal.sample_iter(&mut *stream).take(members).collect();
            add_direction(&mut basis, draw, 1e-9);
        }
        basis
    };
    let (to, from) = (basis(stream), basis(stream));
    let mut rotation = Matrix::zeros(members, members);
    for (t, f) in to.iter().zip(&from) {
        for i in 0..members {
            for j in 0..members {
                rotation[(i, j)] += t[i] * f[j];
            }
        }
    }
    rotation
}
