//! The nearest minimum of the sum of squares over poles, residues and constant together (Levenberg 1944,
//! Marquardt 1963).
//!
//! Vector fitting solves linear problems in which the noisy values multiply the unknowns: with noise its
//! poles settle near the minimum and not in it.

use super::relocate::{Fractions, Samples, least_squares};
use crate::C64;

/// Most steps.
const STEPS: usize = 15;
/// Damping at the start, by what it falls after a good step, and by what it grows after a bad one.
const DAMPING: [f64; 3] = [1e-3, 0.2, 8.0];
/// The largest damping: steps are nothing then.
const STIFF: f64 = 1e6;
/// Part of the sum of squares that a last step gains.
const SETTLED: f64 = 1e-5;

/// From `start`, in the order of its terms: every complex pole is followed by its conjugate. A step that does
/// not lower the sum is not taken, so that the result is never worse.
pub(super) fn polished(samples: &Samples<'_>, start: Fractions) -> Fractions {
    let mut best = start;
    let mut square = sum_of_squares(samples, &best);
    let mut damping = DAMPING[0];
    for _ in 0..STEPS {
        if damping > STIFF {
            break;
        }
        let Some(next) = step(samples, &best, damping) else { break };
        let found = sum_of_squares(samples, &next);
        if found < square {
            let gain = square - found;
            (best, square) = (next, found);
            damping *= DAMPING[1];
            if gain < SETTLED * found {
                break;
            }
        } else {
            damping *= DAMPING[2];
        }
    }
    best
}

fn sum_of_squares(samples: &Samples<'_>, fit: &Fractions) -> f64 {
    let at = |(i, w): (usize, &f64)| (residual(samples, fit, i, *w) * samples.weight(i)).norm_sqr();
    let sum: f64 = samples.omega.iter().enumerate().map(at).sum();
    if sum.is_nan() { f64::INFINITY } else { sum }
}

/// Value less fit.
fn residual(samples: &Samples<'_>, fit: &Fractions, i: usize, omega: f64) -> C64 {
    let s = C64::new(0.0, omega);
    samples.values[i]
        - fit.terms.iter().map(|(pole, residue)| residue / (s - pole)).sum::<C64>()
        - fit.constant
}

/// Slopes of the fit at s: in the constant, then for every pole with Im >= 0 in the parts of its residue and
/// of itself.
fn slopes(fit: &Fractions, s: C64) -> Vec<C64> {
    let mut row = vec![C64::ONE];
    for (pole, residue) in fit.terms.iter().filter(|t| t.0.im >= 0.0) {
        let one = (s - pole).inv();
        let moved = residue * one * one;
        if pole.im == 0.0 {
            row.extend([one, moved]);
        } else {
            let two = (s - pole.conj()).inv();
            let other = residue.conj() * two * two;
            row.extend([one + two, C64::I * (one - two), moved + other, C64::I * (moved - other)]);
        }
    }
    row
}

/// One damped step.
fn step(samples: &Samples<'_>, fit: &Fractions, damping: f64) -> Option<Fractions> {
    let (rows, right): (Vec<Vec<C64>>, Vec<C64>) = samples
        .omega
        .iter()
        .enumerate()
        .map(|(i, w)| {
            let weight = samples.weight(i);
            let row = slopes(fit, C64::new(0.0, *w)).into_iter().map(|v| v * weight).collect::<Vec<_>>();
            (row, residual(samples, fit, i, *w) * weight)
        })
        .unzip();
    let n = rows.first()?.len();
    let parts = |of: &dyn Fn(usize) -> C64| -> Vec<f64> {
        (0..rows.len()).map(|i| of(i).re).chain((0..rows.len()).map(|i| of(i).im)).collect()
    };
    let mut columns: Vec<Vec<f64>> = (0..n).map(|k| parts(&|i| rows[i][k])).collect();
    // A row of each unknown holds it where it is, in units of its own column.
    let sizes: Vec<f64> = columns.iter().map(|c| c.iter().map(|v| v * v).sum::<f64>().sqrt()).collect();
    for (k, column) in columns.iter_mut().enumerate() {
        column.extend((0..n).map(|j| if j == k { damping.sqrt() * sizes[k] } else { 0.0 }));
    }
    let mut target = parts(&|i| right[i]);
    target.extend(std::iter::repeat_n(0.0, n));
    let moved = least_squares(columns, target)?;
    let mut next =
        Fractions { constant: fit.constant + moved[0], terms: Vec::with_capacity(fit.terms.len()) };
    let mut k = 1;
    for (pole, residue) in fit.terms.iter().filter(|t| t.0.im >= 0.0) {
        if pole.im == 0.0 {
            next.terms.push((pole + moved[k + 1], residue + moved[k]));
            k += 2;
        } else {
            let residue = residue + C64::new(moved[k], moved[k + 1]);
            let pole = pole + C64::new(moved[k + 2], moved[k + 3]);
            next.terms.extend([(pole, residue), (pole.conj(), residue.conj())]);
            k += 4;
        }
    }
    Some(next)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A real pole and a pair, and rows with fixed errors.
    fn rows() -> (Vec<f64>, Vec<C64>) {
        let omega: Vec<f64> = (1..60).map(|k| 40.0 * f64::from(k)).collect();
        let exact = |w: f64| {
            let s = C64::new(0.0, w);
            let (p, r) = (C64::new(-150.0, 1100.0), C64::new(90.0, -40.0));
            0.3 + 500.0 / (s + 700.0) + r / (s - p) + r.conj() / (s - p.conj())
        };
        let value = |w: &f64| exact(*w) + 0.02 * C64::new((w * 1.7).sin(), (w * 2.3).cos());
        let values = omega.iter().map(value).collect();
        (omega, values)
    }

    #[test]
    fn exact_at_the_minimum_no_number_can_move_and_gain() {
        let (omega, values) = rows();
        let samples = Samples { omega: &omega, values: &values, sds: &[] };
        let pair = C64::new(-220.0, 1000.0);
        let start = Fractions {
            constant: 0.0,
            terms: vec![
                (C64::new(-500.0, 0.0), C64::new(300.0, 0.0)),
                (pair, C64::new(60.0, 0.0)),
                (pair.conj(), C64::new(60.0, 0.0)),
            ],
        };
        let before = sum_of_squares(&samples, &start);
        let found = polished(&samples, start);
        let square = sum_of_squares(&samples, &found);
        assert!(square < 0.01 * before && square < 59.0 * 4.2e-4, "{before} {square}");
        for k in 0..found.terms.len() {
            for by in [C64::new(0.5, 0.0), C64::new(0.0, 0.5), C64::new(-0.5, 0.0), C64::new(0.0, -0.5)] {
                let mut other = Fractions { constant: found.constant, terms: found.terms.clone() };
                if other.terms[k].0.im < 0.0 || (other.terms[k].0.im == 0.0 && by.im != 0.0) {
                    continue;
                }
                other.terms[k].0 += by;
                if other.terms[k].0.im > 0.0 {
                    other.terms[k + 1].0 += by.conj();
                }
                assert!(sum_of_squares(&samples, &other) > square, "{k} {by}");
            }
        }
    }
}
