//! From white amplitudes to pressures relative to one channel.

use rijke_numerics::{C64, Matrix};
use rijke_rig::{ModeRows, Ping};

/// Pressures relative to the reference channel and their covariance, by the chain rule from the white
/// amplitudes: a = U(s) b, p_m = a_m / a_ref. Every map is analytic, so each complex derivative is a 2 x 2
/// rotation and scaling.
pub(super) fn relative(
    s: C64,
    amplitudes: &[C64],
    reference: usize,
    unwhiten: &[Vec<C64>],
    log_slopes: &[C64],
    covariance: &Matrix,
    variance: f64,
) -> Ping {
    let base = amplitudes[reference];
    let pressures: Vec<C64> = amplitudes.iter().map(|a| a / base).collect();
    let others: Vec<usize> = (0..amplitudes.len()).filter(|&m| m != reference).collect();
    let size = ModeRows::count(others.len());
    let mut map = Matrix::zeros(size, covariance.rows());
    for i in 0..2 {
        map[(i, i)] = 1.0;
    }
    let set = |map: &mut Matrix, row: usize, column: usize, d: C64| {
        map[(row, column)] = d.re;
        map[(row, column + 1)] = -d.im;
        map[(row + 1, column)] = d.im;
        map[(row + 1, column + 1)] = d.re;
    };
    for (i, &m) in others.iter().enumerate() {
        let row = ModeRows::pressure(i);
        set(&mut map, row, 0, pressures[m] * (log_slopes[m] - log_slopes[reference]));
        for n in 0..amplitudes.len() {
            let d = (unwhiten[m][n] - pressures[m] * unwhiten[reference][n]) / base;
            set(&mut map, row, ModeRows::pressure(n), d);
        }
    }
    let full = map.product(covariance).product(&map.transpose());
    let covariance = Matrix::from_fn(size, size, |i, j| 0.5 * variance * (full[(i, j)] + full[(j, i)]));
    Ping { s, pressures, reference, covariance }
}
