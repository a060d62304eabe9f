//! Roots of polynomials.

use rijke_numerics::{C64, complex_eigenvalues};

/// Roots of a polynomial with ascending coefficients, by the eigenvalues of its companion matrix; equal roots
/// are joined if they agree to 1e-6. Leading zeros are dropped; none if the polynomial is constant.
pub(super) fn polynomial_roots(coefficients: &[f64]) -> Vec<(C64, usize)> {
    let degree = coefficients.iter().rposition(|k| *k != 0.0).unwrap_or(0);
    if degree == 0 {
        return Vec::new();
    }
    // s = scale x balances the coefficients of a physical transfer function, whose s is large.
    let scale = (coefficients[0].abs() / coefficients[degree].abs()).powf(1.0 / degree as f64);
    let scale = if scale.is_finite() && scale > 0.0 { scale } else { 1.0 };
    let k = |i: usize| coefficients[i] * scale.powi(i as i32);
    let mut companion = vec![C64::ZERO; degree * degree];
    for i in 0..degree {
        companion[i * degree + degree - 1] = C64::new(-k(i) / k(degree), 0.0);
        if i > 0 {
            companion[i * degree + i - 1] = C64::ONE;
        }
    }
    let mut roots: Vec<(C64, usize)> = Vec::new();
    for x in complex_eigenvalues(&companion, degree).unwrap_or_default() {
        let s = x * scale;
        match roots.iter_mut().find(|r| (r.0 - s).norm() < 1e-6 * scale) {
            Some(root) => root.1 += 1,
            None => roots.push((s, 1)),
        }
    }
    roots
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_double_root_far_from_one_is_joined() {
        // (s + 5e4)^2 (s + 2e5) = s^3 + 3e5 s^2 + 2.25e10 s + 5e14.
        let mut roots = polynomial_roots(&[5e14, 2.25e10, 3e5, 1.0]);
        roots.sort_by_key(|r| r.1);
        let [(single, 1), (double, 2)] = roots[..] else { panic!("{roots:?}") };
        assert!((single + 2e5).norm() < 1e-2 && (double + 5e4).norm() < 1e-1, "{single} {double}");
    }
}
