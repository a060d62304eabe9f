//! The AAA approximant (Nakatsukasa, Sete & Trefethen 2018) as partial fractions.

use super::relocate::Fractions;
use crate::{C64, DenseError, Matrix, complex_eigenvalues, least_direction};

/// The AAA approximant with these support points and their conjugates, as partial fractions; `scale` is of
/// the size of the poles, rad/s.
pub(super) fn fractions(
    omega: &[f64],
    values: &[C64],
    supports: &[usize],
    scale: f64,
) -> Result<Fractions, DenseError> {
    let m = supports.len();
    let rest: Vec<usize> = (0..omega.len()).filter(|k| !supports.contains(k)).collect();
    // Weights a +- i b of each pair; real and imaginary part of each remaining row of Loewner's matrix.
    let mut loewner = Matrix::zeros(2 * rest.len(), 2 * m);
    for (row, &k) in rest.iter().enumerate() {
        let (z, f) = (C64::new(0.0, omega[k]), values[k]);
        for (column, &j) in supports.iter().enumerate() {
            let (zj, fj) = (C64::new(0.0, omega[j]), values[j]);
            let (one, two) = ((f - fj) / (z - zj), (f - fj.conj()) / (z - zj.conj()));
            let (even, odd) = (one + two, C64::I * (one - two));
            loewner[(2 * row, 2 * column)] = even.re;
            loewner[(2 * row + 1, 2 * column)] = even.im;
            loewner[(2 * row, 2 * column + 1)] = odd.re;
            loewner[(2 * row + 1, 2 * column + 1)] = odd.im;
        }
    }
    let unknowns = least_direction(&loewner)?;
    let points: Vec<(C64, C64, C64)> = supports
        .iter()
        .enumerate()
        .flat_map(|(column, &j)| {
            let (z, w) = (C64::new(0.0, omega[j]), C64::new(unknowns[2 * column], unknowns[2 * column + 1]));
            [(z, values[j], w), (z.conj(), values[j].conj(), w.conj())]
        })
        .collect();
    // Zeros of sum w/(s - z): eigenvalues of Z (1 - e w'/sum w), whose one extra eigenvalue is 0.
    let total: C64 = points.iter().map(|p| p.2).sum();
    let n = points.len();
    let pencil: Vec<C64> = (0..n * n)
        .map(|k| {
            let (i, j) = (k / n, k % n);
            let unit = if i == j { points[i].0 } else { C64::ZERO };
            (unit - points[j].0 * points[j].2 / total) / scale
        })
        .collect();
    let mut poles = complex_eigenvalues(&pencil, n)?;
    poles.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
    let residue = |pole: C64| {
        let above: C64 = points.iter().map(|(z, f, w)| w * f / (pole - z)).sum();
        let below: C64 = points.iter().map(|(z, _, w)| -w / ((pole - z) * (pole - z))).sum();
        above / below
    };
    let terms: Vec<(C64, C64)> = poles.iter().skip(1).map(|x| (x * scale, residue(x * scale))).collect();
    let constant = (points.iter().map(|(_, f, w)| f * w).sum::<C64>() / total).re;
    Ok(Fractions { constant, terms })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_partial_fractions_of_a_low_pass_are_its_own() {
        let filter = |omega: f64| 2.0 + 900.0 / C64::new(300.0, omega);
        let omega = [50.0, 130.0, 310.0, 700.0, 1500.0];
        let values = omega.map(filter);
        let found = fractions(&omega, &values, &[2], 1500.0).unwrap();
        let [(pole, residue)] = found.terms[..] else { panic!("{} poles", found.terms.len()) };
        assert!((pole + 300.0).norm() < 1e-8 && (residue - 900.0).norm() < 1e-7, "{pole} {residue}");
        let value = found.constant + residue / (C64::new(0.0, 440.0) - pole);
        assert!((value - filter(440.0)).norm() < 1e-10);
    }
}
