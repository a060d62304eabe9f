//! Howe's conductivity of a circular hole.

use crate::{C64, Jet, JetSpace, Order};
use std::f64::consts::{FRAC_PI_2, PI};

/// Rayleigh's conductivity of a circular hole of radius R with flow through it at velocity U, over its value
/// 2R at rest, with first and second derivative, of z = s R/U: with kappa = -i z, on the imaginary axis the
/// Strouhal number omega R/U,
///
/// 1 + (pi/2 I1 e^-kappa + i K1 sinh kappa)/(kappa (pi/2 I1 e^-kappa - i K1 cosh kappa))
///
/// (Howe 1979, Proc. R. Soc. Lond. A 366, for time dependence e^(-i omega t), conjugate here). It tends to i
/// pi kappa/4 for small Strouhal numbers and to 1 + i/kappa for large ones. Im z < 0 by conjugation.
#[must_use]
pub fn howe(z: C64) -> [C64; 3] {
    let [above, below] = howe_parts(z).map(|[v, d, dd]| Jet::from_parts(v, vec![d], vec![dd]));
    let found = &above / &below;
    [found.value(), found.gradient()[0], found.hessian(0, 0)]
}

/// What [`howe`] divides, and by what, with first and second derivative: pi/2 I1 e^-kappa (1 + kappa) + K1
/// (i sinh kappa - i kappa cosh kappa) and kappa (pi/2 I1 e^-kappa - i K1 cosh kappa). Both are without poles
/// for Im z > 0; their zeros lie where Re z < 0.
#[must_use]
pub fn howe_parts(z: C64) -> [[C64; 3]; 2] {
    if z.im < 0.0 {
        return howe_parts(z.conj()).map(|part| part.map(|v| v.conj()));
    }
    if z == C64::ZERO {
        // The second derivative of the second is that of z^2 ln z, and counts for nothing in the quotient.
        let part = |all: [f64; 3]| all.map(|v| C64::new(0.0, v));
        return [part([0.0, -0.25 * PI, 2.0 / 3.0]), part([-1.0, 0.0, 0.0])];
    }
    let kappa = C64::new(z.im, -z.re);
    let bad = C64::new(f64::NAN, f64::NAN);
    let turned = (kappa.re.abs() - kappa).exp();
    let i = |order: f64| complex_bessel::besseli_scaled(order, kappa).unwrap_or(bad) * turned;
    let k = |order: f64| complex_bessel::besselk_scaled(order, kappa).unwrap_or(bad);
    let [i1, i2, k0, k1] = [i(1.0), i(2.0), k(0.0), k(1.0)];
    // a = I1 e^-kappa and b = K1 e^kappa with their derivatives (DLMF 10.29.2, 10.29.3).
    let r = kappa.inv();
    let a1 = i2 + i1 * r - i1;
    let a2 = 2.0 * i1 - i2 * r - 2.0 * (i2 + i1 * r);
    let [b1, b0] = [-k0 - k1 * r + k1, k0 - k1];
    let b2 = -b0 - b1 * r + k1 * r * r + b1;
    let space = JetSpace::new(1, Order::Second);
    // d kappa/dz = -i.
    let x = Jet::from_parts(kappa, vec![-C64::I], vec![C64::ZERO]);
    let a = x.compose(i1, a1, a2).scale(C64::new(FRAC_PI_2, 0.0));
    let b = x.compose(k1, b1, b2).scale(C64::new(0.0, 0.5));
    let [g, g1, g2] = twice_sinh_less(kappa);
    let square = x.scale(C64::new(-2.0, 0.0)).exp();
    let above = &(&a * &(&space.real(1.0) + &x)) + &(&b * &x.compose(g, g1, g2));
    let below = &x * &(&a - &(&b * &(&space.real(1.0) + &square)));
    [above, below].map(|part| [part.value(), part.gradient()[0], part.hessian(0, 0)])
}

/// 2 e^-k (sinh k - k cosh k) and its first two derivatives. Sinh and k cosh agree to k^3/3 where k is small.
fn twice_sinh_less(k: C64) -> [C64; 3] {
    if k.norm() > 1.0 {
        let square = (-2.0 * k).exp();
        let value = 1.0 - square - k * (1.0 + square);
        let slope = square * (1.0 + 2.0 * k) - 1.0;
        return [value, slope, -4.0 * k * square];
    }
    // -sum of 2n k^(2n+1)/(2n+1)! over n from 1.
    let (mut term, mut sum) = (k, C64::ZERO);
    for n in (2..30).step_by(2).map(f64::from) {
        term *= k * k / (n * (n + 1.0));
        sum -= n * term;
    }
    let [sinh, cosh] = [k.sinh(), k.cosh()];
    let (slope, curvature) = (-k * sinh, -sinh - k * cosh);
    let all = [sum, slope - sum, curvature - 2.0 * slope + sum];
    all.map(|part| 2.0 * (-k).exp() * part)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::{slopes_from, slopes_near};

    /// By the integrals I1 = (1/pi) int_0^pi e^(k cos t) cos t dt, K1 = int_0^inf e^(-k cosh t) cosh t dt
    /// (DLMF 10.32.3, 10.32.9), Re k > 0, and hyperbolic functions as they stand.
    fn by_quadrature(kappa: C64) -> C64 {
        let n = 4000;
        let mid = |length: f64, f: &dyn Fn(f64) -> C64| -> C64 {
            (0..n).map(|j| f(length * (j as f64 + 0.5) / n as f64)).sum::<C64>() * (length / n as f64)
        };
        let i1 = mid(PI, &|t| (kappa * t.cos()).exp() * t.cos()) / PI;
        let k1 = mid(9.0, &|t| (-kappa * t.cosh()).exp() * t.cosh());
        let a = FRAC_PI_2 * i1 * (-kappa).exp();
        1.0 + (a + C64::I * k1 * kappa.sinh()) / (kappa * (a - C64::I * k1 * kappa.cosh()))
    }

    #[test]
    fn oracle_howe_by_quadrature_and_its_limits() {
        for (strouhal, decay) in [(0.05, 0.0), (0.3, 0.02), (1.0, -0.2), (2.0, 0.5), (6.0, -1.0), (12.0, 0.3)]
        {
            let found = howe(C64::new(decay, strouhal))[0];
            let expected = by_quadrature(C64::new(strouhal, -decay));
            assert!((found - expected).norm() < 1e-6 * expected.norm(), "{strouhal}: {found} {expected}");
            let mirrored = howe(C64::new(decay, -strouhal))[0];
            assert!((mirrored - found.conj()).norm() < 1e-15);
        }
        // Small: i pi kappa/4 + kappa^2/3; large: 1 + i/kappa. Each to the next order.
        let small = |k: f64| (howe(C64::new(0.0, k))[0] - C64::new(k * k / 3.0, 0.25 * PI * k)).norm();
        assert!(small(1e-3) < 1e-7 && small(1e-3) < 0.03 * 1e-6 * 20.0, "{}", small(1e-3));
        // The next order is kappa^3 with its logarithm.
        for size in [1e-4, 1e-6, 1e-8, 1e-12] {
            let z = C64::from_polar(size, 1.2);
            let [value, slope, curvature] = howe(z);
            let gap = value - 0.25 * PI * z + z * z / 3.0;
            assert!(gap.norm() < 1e-15 * size + 20.0 * size.powi(3), "{size}: {gap}");
            assert!((slope - 0.25 * PI + z / 1.5).norm() < 1e-14 + 20.0 * size * size, "{size}: {slope}");
            let rounding = 1e-15 / size;
            assert!((curvature + 2.0 / 3.0).norm() < 1e-4 + 20.0 * size + rounding, "{size}: {curvature}");
        }
        let [value, slope, curvature] = howe(C64::ZERO);
        assert!(
            value == C64::ZERO
                && (slope - 0.25 * PI).norm() < 1e-15
                && (curvature + 2.0 / 3.0).norm() < 1e-15
        );
        // On both sides of where the series ends.
        let [inside, outside] = [0.999_999, 1.000_001].map(|k| howe(C64::from_polar(k, 1.1)));
        for (a, b) in inside.iter().zip(&outside) {
            assert!((a - b).norm() < 1e-5, "{a} {b}");
        }
        let large = |k: f64| (howe(C64::new(0.0, k))[0] - C64::new(1.0, k.recip())).norm();
        assert!(large(400.0) < 5.0 / (400.0 * 400.0), "{}", large(400.0));
        assert!(howe(C64::new(3.0, 1e5))[0].is_finite());
    }

    #[test]
    fn order_taylor_remainders_of_howe() {
        for z in [C64::new(0.1, 0.4), C64::new(-0.3, 3.0), C64::new(0.2, -1.5)] {
            let [f, slope, curvature] = howe(z);
            let d = C64::new(0.3, 0.2);
            let gap = |h: f64| howe(z + d * h)[0] - f - slope * d * h;
            slopes_near(&slopes_from(0.2, |h| gap(h).norm()), 2.0, 0.1);
            let second = 0.5 * curvature * d * d;
            slopes_near(&slopes_from(0.2, |h| (gap(h) - second * h * h).norm()), 3.0, 0.1);
        }
    }
}
