//! Whether a polynomial has growing roots.

/// Differences of numbers that agree to this part of them are 0.
const ROUNDING: f64 = 1e-13;

/// Whether a polynomial, its coefficients ascending, has a root with a positive real part: whether the signs
/// in the first column of Routh's array (1877) change. A row of zeros is that of roots in pairs about zero,
/// of which the row above is the polynomial; its derivative takes the place (Gantmacher, *The theory of
/// matrices* 2, chapter XV). A zero at the beginning of another row no polynomial without growing roots has.
#[must_use]
pub fn has_growing_root(ascending: &[f64]) -> bool {
    let mut all: Vec<f64> = ascending.to_vec();
    while all.last() == Some(&0.0) {
        all.pop();
    }
    all.reverse();
    let mut rows = [0, 1].map(|first| all.iter().skip(first).step_by(2).copied().collect::<Vec<f64>>());
    // Degree of the upper row.
    for degree in (1..all.len()).rev() {
        let [upper, mut lower] = rows;
        if lower.iter().all(|k| *k == 0.0) {
            let derivative = upper.iter().enumerate().map(|(k, a)| (degree as f64 - 2.0 * k as f64) * a);
            lower = derivative.take(degree.div_ceil(2)).collect();
        }
        let (a, b) = (upper[0], lower[0]);
        if b == 0.0 || a * b < 0.0 {
            return true;
        }
        let of = |row: &[f64], k: usize| row.get(k).copied().unwrap_or(0.0);
        let next = |k: usize| {
            let (one, other) = (of(&upper, k), a / b * of(&lower, k));
            let apart = one - other;
            if apart.abs() <= ROUNDING * (one.abs() + other.abs()) { 0.0 } else { apart }
        };
        let next = (1..upper.len()).map(next).collect();
        rows = [lower, next];
    }
    false
}

#[cfg(test)]
mod tests {
    use super::has_growing_root as grows;
    use crate::{C64, complex_eigenvalues};

    /// The product of (s - r) over roots r, conjugate pairs given by one of them.
    fn product(roots: &[(f64, f64)]) -> Vec<f64> {
        roots.iter().fold(vec![1.0], |all, &(re, im)| {
            let factor = if im == 0.0 { vec![-re, 1.0] } else { vec![re * re + im * im, -2.0 * re, 1.0] };
            let mut out = vec![0.0; all.len() + factor.len() - 1];
            all.iter().enumerate().for_each(|(i, a)| {
                factor.iter().enumerate().for_each(|(j, b)| out[i + j] += a * b);
            });
            out
        })
    }

    #[test]
    fn exact_a_polynomial_grows_if_it_has_a_root_to_the_right() {
        for stable in
            [&[(-3.0, 0.0)][..], &[(-0.1, 40.0), (-2.0, 1.0)], &[(-1.0, 0.0), (-0.01, 9.0), (-5.0, 0.0)]]
        {
            let polynomial = product(stable);
            assert!(!grows(&polynomial) && !grows(&polynomial.iter().map(|k| -k).collect::<Vec<_>>()));
            for k in 0..stable.len() {
                let mut other = stable.to_vec();
                other[k].0 *= -1.0;
                assert!(grows(&product(&other)), "{other:?}");
            }
        }
        assert!(!grows(&[1.0]) && !grows(&[2.0, 0.0]));
    }

    /// With zeros anywhere, roots on the imaginary axis and pairs about zero.
    #[test]
    fn oracle_polynomials_of_small_integers_against_eigenvalues() {
        let (mut grew, mut tried) = (0, 0);
        for degree in 2..6 {
            for code in 0..5_usize.pow(degree) {
                let digit = |k: u32| (code / 5_usize.pow(k) % 5) as f64 - 2.0;
                let mut polynomial: Vec<f64> = (0..degree).map(digit).collect();
                polynomial.push(1.0);
                let n = degree as usize;
                let companion: Vec<C64> = (0..n * n)
                    .map(|at| match (at / n, at % n) {
                        (i, j) if j + 1 == n => C64::new(-polynomial[i], 0.0),
                        (i, j) => C64::new(f64::from(u8::from(i == j + 1)), 0.0),
                    })
                    .collect();
                let roots = complex_eigenvalues(&companion, n).unwrap();
                let rightmost = roots.iter().map(|r| r.re).fold(f64::NEG_INFINITY, f64::max);
                // Roots of any order on the axis are moved off it by the root of the rounding.
                assert_eq!(grows(&polynomial), rightmost > 1e-2, "{polynomial:?} {roots:?}");
                (grew, tried) = (grew + usize::from(rightmost > 1e-2), tried + 1);
            }
        }
        assert!(grew > 1000 && tried - grew > 50, "{grew} of {tried}");
        assert!(!grows(&[1.0, 0.0, 2.0, 0.0, 1.0]) && grows(&[1.0, -2e-3, 0.0, 1e-9]));
    }
}
