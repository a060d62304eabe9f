//! Special functions of a complex variable.

use crate::C64;

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
}
