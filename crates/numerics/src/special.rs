//! Special functions of a complex variable, and Legendre's polynomials.

use crate::C64;

/// The first `count` Legendre polynomials at x, each of unit root mean square over -1 .. 1.
#[must_use]
pub fn legendre(x: f64, count: usize) -> Vec<f64> {
    let (mut before, mut here) = (0.0, 1.0);
    (0..count)
        .map(|n| {
            let scaled = here * ((2 * n + 1) as f64).sqrt();
            let next = ((2 * n + 1) as f64 * x * here - n as f64 * before) / (n + 1) as f64;
            (before, here) = (here, next);
            scaled
        })
        .collect()
}

/// r(z) = I1(z)/I0(z) for Re z >= 0, to rounding; r' = 1 - r/z - r^2.
#[must_use]
pub fn bessel_ratio(z: C64) -> C64 {
    /// Beyond this modulus the asymptotic series reaches 1e-15 before it diverges.
    const FAR: f64 = 40.0;
    if z.norm_sqr() > FAR * FAR {
        let inverse = z.inv();
        return asymptotic(inverse, 4.0) / asymptotic(inverse, 0.0);
    }
    let scaled = |order| complex_bessel::besseli_scaled(order, z);
    match (scaled(1.0), scaled(0.0)) {
        (Ok(one), Ok(zero)) => one / zero,
        _ => C64::new(f64::NAN, f64::NAN),
    }
}

/// Hankel's series of sqrt(2 pi z) e^{-z} I_nu(z), `mu` = 4 nu^2 (DLMF 10.40.1).
fn asymptotic(inverse: C64, mu: f64) -> C64 {
    let (mut term, mut sum) = (C64::ONE, C64::ONE);
    for k in 1..=24 {
        let odd = f64::from(2 * k - 1);
        term *= inverse * (-(mu - odd * odd) / (8.0 * f64::from(k)));
        sum += term;
        if term.norm_sqr() < 1e-34 {
            break;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// I1/I0 as the continued fraction z/(2 + z^2/(4 + z^2/(6 + ...))) (DLMF 10.33.1).
    fn continued_fraction(z: C64) -> C64 {
        let tail = (1..=300).rev().fold(C64::ZERO, |below, k| z * z / (f64::from(2 * k) + below));
        tail / z
    }

    #[test]
    fn oracle_the_ratio_agrees_with_its_continued_fraction() {
        // On both sides of the change to the asymptotic series at |z| = 40; the angle of z = R sqrt(s
        // rho/mu) is near 45 degrees.
        for modulus in [1e-3, 0.3, 2.0, 11.0, 39.9, 40.1, 75.0] {
            for angle in [-0.8, 0.0, 0.4, 0.8] {
                let z = C64::from_polar(modulus, angle);
                let (ours, theirs) = (bessel_ratio(z), continued_fraction(z));
                assert!((ours - theirs).norm() <= 1e-13 * theirs.norm(), "{z}: {ours} {theirs}");
            }
        }
    }

    #[test]
    fn exact_polynomials_are_orthogonal_and_of_unit_mean_square() {
        let n = 4000;
        let at = |k: usize| -1.0 + (2 * k + 1) as f64 / n as f64;
        for (i, j) in [(0, 0), (3, 3), (7, 7), (2, 4), (0, 6)] {
            let mean = (0..n)
                .map(|k| {
                    let p = legendre(at(k), 8);
                    p[i] * p[j]
                })
                .sum::<f64>()
                / n as f64;
            let expected = if i == j { 1.0 } else { 0.0 };
            assert!((mean - expected).abs() < 1e-4, "{i} {j}: {mean}");
        }
    }
}
