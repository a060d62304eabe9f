//! Rational functions by least squares: residues for given poles, and better poles (Gustavsen & Semlyen 1999,
//! vector fitting; relaxed as in Gustavsen 2006).
//!
//! Poles are given by those with Im >= 0; a complex one stands for itself and its conjugate.

use crate::{C64, DenseError, Matrix, complex_eigenvalues, least_direction};

/// constant + sum of residue/(s - pole), with every pole its conjugate.
pub(super) struct Fractions {
    pub(super) constant: f64,
    pub(super) terms: Vec<(C64, C64)>,
}

/// Values at i omega.
pub(super) struct Samples<'a> {
    pub(super) omega: &'a [f64],
    pub(super) values: &'a [C64],
    /// The standard deviation of each, in proportion; empty if all have the same.
    pub(super) sds: &'a [f64],
}

impl Samples<'_> {
    /// What the equation of sample `i` is multiplied by.
    pub(super) fn weight(&self, i: usize) -> f64 {
        self.sds.get(i).map_or(1.0, |sd| 1.0 / sd)
    }
}

/// Poles of `order` spread over the band, of a damping of 1 %.
pub(super) fn spread(order: usize, [low, high]: [f64; 2]) -> Vec<C64> {
    let pairs = order / 2;
    let at = |k: usize| low + (high - low) * (k as f64 + 0.5) / pairs as f64;
    let mut poles: Vec<C64> = (0..pairs).map(|k| C64::new(-0.01 * at(k), at(k))).collect();
    if order % 2 == 1 {
        poles.push(C64::new(-0.5 * (low + high), 0.0));
    }
    poles
}

/// The poles with Im >= 0 of a list that holds every conjugate.
pub(super) fn upper(poles: impl Iterator<Item = C64>) -> Vec<C64> {
    let real = |z: C64| z.im.abs() <= 1e-9 * z.norm();
    poles
        .filter_map(|z| if real(z) { Some(C64::new(z.re, 0.0)) } else { (z.im > 0.0).then_some(z) })
        .collect()
}

/// The real functions that the poles span, at s.
fn basis(s: C64, poles: &[C64]) -> Vec<C64> {
    let mut row = Vec::with_capacity(2 * poles.len());
    for pole in poles {
        let one = (s - pole).inv();
        if pole.im == 0.0 {
            row.push(one);
        } else {
            let two = (s - pole.conj()).inv();
            row.extend([one + two, C64::I * (one - two)]);
        }
    }
    row
}

/// With every pole its conjugate, from coefficients of the real functions.
fn terms(poles: &[C64], coefficients: &[f64]) -> Vec<(C64, C64)> {
    let (mut k, mut out) = (0, Vec::new());
    for pole in poles {
        if pole.im == 0.0 {
            out.push((*pole, C64::new(coefficients[k], 0.0)));
            k += 1;
        } else {
            let residue = C64::new(coefficients[k], coefficients[k + 1]);
            out.extend([(*pole, residue), (pole.conj(), residue.conj())]);
            k += 2;
        }
    }
    out
}

/// The best residues and constant for these poles.
pub(super) fn residues(samples: &Samples<'_>, poles: &[C64]) -> Option<Fractions> {
    let rows: Vec<Vec<C64>> = samples.omega.iter().map(|w| basis(C64::new(0.0, *w), poles)).collect();
    let n = rows.first()?.len();
    let part = |v: &dyn Fn(usize) -> C64| -> Vec<f64> {
        let all: Vec<C64> = (0..rows.len()).map(|i| v(i) * samples.weight(i)).collect();
        all.iter().map(|z| z.re).chain(all.iter().map(|z| z.im)).collect()
    };
    let mut columns: Vec<Vec<f64>> = (0..n).map(|k| part(&|i| rows[i][k])).collect();
    columns.push(part(&|_| C64::ONE));
    let solution = least_squares(columns, part(&|i| samples.values[i]))?;
    Some(Fractions { constant: solution[n], terms: terms(poles, &solution) })
}

/// Poles one step of vector fitting on.
pub(super) fn relocate(samples: &Samples<'_>, poles: &[C64]) -> Result<Vec<C64>, DenseError> {
    let first = basis(C64::new(0.0, samples.omega[0]), poles).len();
    let (n, m) = (2 * (first + 1), samples.omega.len());
    let mut a = Matrix::zeros(2 * m, n);
    for (i, (w, f)) in samples.omega.iter().zip(samples.values).enumerate() {
        let mut row = basis(C64::new(0.0, *w), poles);
        row.push(C64::ONE);
        let turned: Vec<C64> = row.iter().map(|v| -f * v).collect();
        for (k, v) in row.into_iter().chain(turned).enumerate() {
            let v = v * samples.weight(i);
            (a[(i, k)], a[(m + i, k)]) = (v.re, v.im);
        }
    }
    let scale: Vec<f64> = (0..n)
        .map(|k| (0..2 * m).map(|i| a[(i, k)].powi(2)).sum::<f64>().sqrt().max(f64::MIN_POSITIVE))
        .collect();
    for i in 0..2 * m {
        for (k, s) in scale.iter().enumerate() {
            a[(i, k)] /= s;
        }
    }
    let unknowns: Vec<f64> = least_direction(&a)?.iter().zip(&scale).map(|(x, s)| x / s).collect();
    let (shares, below) = (&unknowns[first + 1..n - 1], unknowns[n - 1]);
    let all = terms(poles, shares);
    let size = all.iter().map(|t| t.0.norm()).fold(f64::MIN_POSITIVE, f64::max);
    let matrix: Vec<C64> = (0..all.len() * all.len())
        .map(|k| {
            let (i, j) = (k / all.len(), k % all.len());
            let unit = if i == j { all[i].0 } else { C64::ZERO };
            (unit - all[j].1 / below) / size
        })
        .collect();
    Ok(upper(complex_eigenvalues(&matrix, all.len())?.into_iter().map(|z| z * size)))
}

/// x that makes |sum of x_k column_k - b| least, by Gram and Schmidt, twice; `None` if columns are dependent.
pub(super) fn least_squares(mut columns: Vec<Vec<f64>>, mut b: Vec<f64>) -> Option<Vec<f64>> {
    let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
    let n = columns.len();
    let mut r = vec![vec![0.0; n]; n];
    let mut q: Vec<Vec<f64>> = Vec::new();
    let mut right = vec![0.0; n];
    for (k, mut column) in columns.drain(..).enumerate() {
        let before = dot(&column, &column).sqrt();
        for _ in 0..2 {
            for (j, unit) in q.iter().enumerate() {
                let part = dot(unit, &column);
                r[j][k] += part;
                column.iter_mut().zip(unit).for_each(|(c, u)| *c -= part * u);
            }
        }
        let norm = dot(&column, &column).sqrt();
        if norm.is_nan() || norm <= 1e-13 * before {
            return None;
        }
        r[k][k] = norm;
        column.iter_mut().for_each(|c| *c /= norm);
        right[k] = dot(&column, &b);
        b.iter_mut().zip(&column).for_each(|(b, u)| *b -= right[k] * u);
        q.push(column);
    }
    let mut x = vec![0.0; n];
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| r[k][j] * x[j]).sum();
        x[k] = (right[k] - known) / r[k][k];
    }
    Some(x)
}
