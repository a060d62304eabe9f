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
///
/// Where Re z > 18, e^(-2z) is below rounding and r is its asymptotic series in 1/z.
#[must_use]
pub fn bessel_ratio(z: C64) -> C64 {
    if z.re > 18.0 {
        // The terms fall like n!/(2|z|)^n: so many reach 1e-16.
        let terms = match z.norm_sqr() {
            square if square > 80.0 * 80.0 => 11,
            square if square > 40.0 * 40.0 => 16,
            square if square > 25.0 * 25.0 => 22,
            _ => FAR.len(),
        };
        let inverse = z.inv();
        return FAR[..terms].iter().rev().fold(C64::ZERO, |sum, a| sum * inverse + a);
    }
    let scaled = |order| complex_bessel::besseli_scaled(order, z);
    match (scaled(1.0), scaled(0.0)) {
        (Ok(one), Ok(zero)) => one / zero,
        _ => C64::new(f64::NAN, f64::NAN),
    }
}

/// The asymptotic series I1/I0 = sum a_n z^-n. With r' = 1 - r/z - r^2: a_0 = 1 and 2 a_n = (n - 2) a_(n-1) - sum_(0<i<n) a_i a_(n-i).
const FAR: [f64; 34] = {
    let mut a = [1.0; 34];
    let mut n = 1;
    while n < 34 {
        let mut twice = (n as f64 - 2.0) * a[n - 1];
        let mut i = 1;
        while i < n {
            twice -= a[i] * a[n - i];
            i += 1;
        }
        a[n] = 0.5 * twice;
        n += 1;
    }
    a
};

#[cfg(test)]
mod tests {
    use super::*;

    /// I1/I0 as the continued fraction z/(2 + z^2/(4 + z^2/(6 + ...))) (DLMF 10.33.1).
    fn continued_fraction(z: C64) -> C64 {
        let tail = (1..=600).rev().fold(C64::ZERO, |below, k| z * z / (f64::from(2 * k) + below));
        tail / z
    }

    #[test]
    fn oracle_the_ratio_agrees_with_its_continued_fraction() {
        // On both sides of every change of the series; the angle of z = R sqrt(s rho/mu) is near 45 degrees, more where a mode
        // decays.
        for modulus in [1e-3, 0.3, 2.0, 11.0, 17.9, 18.1, 24.9, 25.6, 39.9, 40.1, 75.0, 81.0, 150.0] {
            for angle in [-0.8, 0.0, 0.4, 0.8, 1.2, 1.5] {
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
