//! Reflection from an unflanged open end (Levine & Schwinger 1948), continued analytically to complex ka.
//!
//! On the real axis the two printed integrals are |R| = exp(-(2/pi) ∫ arctan(-J1/N1) ...) and l/a; together
//! they are one analytic function,
//!
//! ln(-R) = -(2i/pi) [ ∫_0^{pi/2} f(ka sin t)/sin t dt + ka ∫_0^inf ln(1/(2 I1(x) K1(x)))/(x sqrt(x^2 +
//! (ka)^2)) dx ], f(z) = ln(-i pi J1(z) H1^(2)(z)),
//!
//! whose real part on the real axis is the first integral and whose imaginary part is -2 ka l/a.
//! [`integrals`] evaluates it; [`reflection`] uses Taylor patches in w = ln ka, where the logarithm at ka = 0
//! is harmless.

use rijke_numerics::C64;
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::OnceLock;

/// R(ka) with its first and second derivative in ka, ka = s a/(i c).
///
/// Valid for 1e-5 <= |ka| <= 2, and below by the leading terms; NaN beyond, where a tube carries more than
/// plane waves anyway (ka = 1.84). Re ka < 0 (negative frequencies) by R(-ka*) = R(ka)*. Agrees with
/// [`integrals`] to 1e-11 for arguments of ka below 1.3 in size, that is, unless a mode grows or decays
/// several times faster than it oscillates, and to 1e-8 up to pi/2. Cost: one complex logarithm and 40
/// products; the first call in a patch computes it (some milliseconds, kept for the life of the process, the
/// same whatever the thread).
#[must_use]
pub fn reflection(ka: C64) -> [C64; 3] {
    if ka.re < 0.0 {
        let [r, r1, r2] = reflection(-ka.conj());
        return [r.conj(), -r1.conj(), r2.conj()];
    }
    let [h, h1, h2] = exponent(ka);
    let r = -(ka * h).exp();
    // ln(-R) = ka h(w), d/dka = (h + h_w), d2/dka2 = (h_w + h_ww)/ka with w = ln ka.
    let slope = h + h1;
    [r, r * slope, r * (slope * slope + (h1 + h2) / ka)]
}

/// End correction over radius of the long-wave limit; Levine and Schwinger printed 0.6133.
pub const END_CORRECTION: f64 = 0.612_701_035;

/// h(w) = ln(-R)/ka as a function of w = ln ka, with two derivatives in w.
fn exponent(ka: C64) -> [C64; 3] {
    if ka.norm() < SMALLEST {
        // ln(-R) = -2i (l/a) ka - (ka)^2/2 + O(ka^3 ln ka).
        let second = -0.5 * ka;
        return [C64::new(0.0, -2.0 * END_CORRECTION) + second, second, second];
    }
    let w = ka.ln();
    let row = ((w.re - FIRST) / WIDTH).floor();
    let column = ((w.im + FRAC_PI_2) / HEIGHT).floor().min(COLUMNS as f64 - 1.0);
    if !(0.0..ROWS as f64).contains(&row) || !(0.0..COLUMNS as f64).contains(&column) {
        return [C64::new(f64::NAN, f64::NAN); 3];
    }
    let centre = C64::new(FIRST + (row + 0.5) * WIDTH, -FRAC_PI_2 + (column + 0.5) * HEIGHT);
    static PATCHES: [OnceLock<[C64; TERMS]>; ROWS * COLUMNS] = [const { OnceLock::new() }; ROWS * COLUMNS];
    let patch = PATCHES[row as usize * COLUMNS + column as usize].get_or_init(|| taylor(centre));
    let d = w - centre;
    let (mut h, mut h1, mut h2) = (C64::ZERO, C64::ZERO, C64::ZERO);
    for &k in patch.iter().rev() {
        h2 = h2 * d + h1;
        h1 = h1 * d + h;
        h = h * d + k;
    }
    [h, h1, 2.0 * h2]
}

const SMALLEST: f64 = 1e-5;
/// ln 1e-5: where the patches begin.
const FIRST: f64 = -11.512_925_464_970_229;
/// Patches from |ka| = 1e-5 to 2 in steps of a factor e^0.3.
const ROWS: usize = 41;
const WIDTH: f64 = 0.3;
const COLUMNS: usize = 10;
const HEIGHT: f64 = PI / COLUMNS as f64;
const TERMS: usize = 22;

/// Taylor coefficients about `centre` by Cauchy's integral over a circle. The nearest singularities are the
/// zero of J1 at ka = 3.83 (w = 1.34) and the zeros of H1^(2) behind the imaginary axis (w = -0.34 +- 2.2i).
fn taylor(centre: C64) -> [C64; TERMS] {
    const POINTS: usize = 48;
    const RADIUS: f64 = 0.5;
    let samples: Vec<C64> = (0..POINTS)
        .map(|k| {
            let ka = (centre + C64::from_polar(RADIUS, 2.0 * PI * k as f64 / POINTS as f64)).exp();
            logarithm(ka) / ka
        })
        .collect();
    std::array::from_fn(|n| {
        let turn = |k: usize| C64::from_polar(1.0, -2.0 * PI * ((n * k) % POINTS) as f64 / POINTS as f64);
        let sum: C64 = samples.iter().enumerate().map(|(k, h)| h * turn(k)).sum();
        sum / (POINTS as f64 * RADIUS.powi(n as i32))
    })
}

/// R(ka) from the integrals, for 0 < |ka| < 3.3 and Re ka > 0; the slow route, about a millisecond.
#[must_use]
pub fn integrals(ka: C64) -> C64 {
    -logarithm(ka).exp()
}

/// ln(-R).
fn logarithm(ka: C64) -> C64 {
    C64::new(0.0, -2.0 / PI) * (near(ka) + ka * far(ka))
}

/// ∫_0^{pi/2} f(ka sin t)/sin t dt, with t = (pi/2)/(1 + e^{-2y}), y = sinh-like double exponential: the
/// integrand vanishes as t ln t at t = 0 and is even about pi/2, so both ends decay fast.
fn near(ka: C64) -> C64 {
    const STEP: f64 = 0.11;
    let mut total = C64::ZERO;
    for k in -36..=36 {
        let y = f64::from(k) * STEP;
        let inner = FRAC_PI_2 * y.sinh();
        let fraction = 1.0 / (1.0 + (-2.0 * inner).exp());
        let weight = FRAC_PI_2 * y.cosh() / inner.cosh().powi(2) * 0.5 * FRAC_PI_2;
        let sine = (FRAC_PI_2 * fraction).sin();
        if sine > 1e-12 && weight > 0.0 {
            total += kernel(ka * sine) * (weight / sine);
        }
    }
    total * STEP
}

/// ln(-i pi J1(z) H1^(2)(z)); tends to 0 with z.
fn kernel(z: C64) -> C64 {
    match (complex_bessel::besselj(1.0, z), complex_bessel::hankel2(1.0, z)) {
        (Ok(j), Ok(h)) => (C64::new(0.0, -PI) * j * h).ln(),
        _ => C64::new(f64::NAN, f64::NAN),
    }
}

/// ∫_0^inf ln(1/(2 I1 K1))/(x sqrt(x^2 + ka^2)) dx along x = e^{y + i turn}, by the trapezoidal rule in y.
/// The ray is turned with ka so that the branch points x = +- i ka and the zeros of I1 on the imaginary axis
/// stay away from it. The root is taken of 1 +- i ka/x, whose argument never reaches pi; sqrt(x^2 + ka^2)
/// would cross its cut.
fn far(ka: C64) -> C64 {
    const TURNS: [f64; 3] = [-1.0, 0.0, 1.0];
    let table = if ka.arg() > 0.5 { 2 } else { usize::from(ka.arg() >= -0.5) };
    static NODES: [OnceLock<Vec<[C64; 2]>>; 3] = [const { OnceLock::new() }; 3];
    let nodes = NODES[table].get_or_init(|| far_nodes(TURNS[table]));
    let term = |[x, g]: &[C64; 2]| {
        let r = C64::I * ka / x;
        g / (x * (1.0 + r).sqrt() * (1.0 - r).sqrt())
    };
    nodes.iter().map(term).sum::<C64>() * FAR_STEP
}

const FAR_STEP: f64 = 0.1;

/// Nodes x and ln(1/(2 I1 K1)) there, from x = e^-26, where the integrand is below 1e-20, to e^40.
fn far_nodes(turn: f64) -> Vec<[C64; 2]> {
    let count = (66.0 / FAR_STEP) as usize;
    (0..=count)
        .map(|k| {
            let x = C64::from_polar((-26.0 + k as f64 * FAR_STEP).exp(), turn);
            [x, -double_product(x)]
        })
        .collect()
}

/// ln(2 I1(x) K1(x)).
fn double_product(x: C64) -> C64 {
    if x.norm() < 1e-4 {
        // 2 I1 K1 = 1 + (x^2/2) (ln(x/2) + gamma - 1/4) + O(x^4 ln x)  (DLMF 10.31.1, 10.25.2)
        const EULER: f64 = 0.577_215_664_901_532_9;
        return 0.5 * x * x * ((0.5 * x).ln() + EULER - 0.25);
    }
    if x.norm() > 100.0 {
        // 2 I1 K1 ~ (1/x) (1 - 3/(8 x^2) - 45/(128 x^4) - ...)  (DLMF 10.40.6)
        let r = (x * x).inv();
        return -x.ln() + (1.0 - r * (0.375 + r * 45.0 / 128.0)).ln();
    }
    match (complex_bessel::besseli_scaled(1.0, x), complex_bessel::besselk_scaled(1.0, x)) {
        // The scalings are e^{-|Re x|} and e^{x}: undo their product e^{i Im x}.
        (Ok(i), Ok(k)) => (2.0 * i * k * C64::new(0.0, -x.im).exp()).ln(),
        _ => C64::new(f64::NAN, f64::NAN),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Vec<[f64; 4]> {
        let text = include_str!("../../../../fixtures/reference/levine_schwinger.csv");
        text.lines()
            .filter(|l| l.starts_with(|c: char| c.is_ascii_digit()))
            .map(|l| {
                let numbers: Vec<f64> = l.split(',').map(|v| v.parse().unwrap()).collect();
                [numbers[0], numbers[1], numbers[2], numbers[3]]
            })
            .collect()
    }

    #[test]
    fn oracle_table_of_exact_values() {
        for [ka, modulus, correction, _] in table() {
            for r in [integrals(C64::new(ka, 0.0)), reflection(C64::new(ka, 0.0))[0]] {
                assert!((r.norm() - modulus).abs() < 1.1e-10, "|R| at {ka}: {} against {modulus}", r.norm());
                let l = (PI - r.arg()) / (2.0 * ka);
                assert!((l - correction).abs() < 1e-9, "l/a at {ka}: {l} against {correction}");
            }
        }
    }

    #[test]
    fn oracle_patches_agree_with_the_integrals() {
        for modulus in [3e-4, 0.01, 0.0708, 0.3, 0.9, 1.95] {
            for (angle, tolerance) in
                [(0.0, 1e-11), (0.1, 1e-11), (-0.1, 1e-11), (0.7, 1e-11), (-1.25, 1e-11), (1.5, 1e-8)]
            {
                let ka = C64::from_polar(modulus, angle);
                let error = (reflection(ka)[0] - integrals(ka)).norm();
                assert!(error < tolerance, "at {ka}: {error:e}");
            }
        }
    }

    #[test]
    fn order_derivatives_by_taylor_remainders() {
        use rijke_numerics::check::{slopes_from, slopes_near};
        for ka in [C64::new(0.0708, -0.002), C64::new(0.6, 0.3), C64::new(-0.1, 0.02)] {
            let [r, r1, r2] = reflection(ka);
            let step = C64::from_polar(ka.norm(), 0.4);
            let first = |h: f64| (reflection(ka + step * h)[0] - r - r1 * step * h).norm();
            let second = |h: f64| {
                let d = step * h;
                (reflection(ka + d)[0] - r - r1 * d - 0.5 * r2 * d * d).norm()
            };
            slopes_near(&slopes_from(0.1, first), 2.0, 0.05);
            slopes_near(&slopes_from(0.2, second), 3.0, 0.05);
        }
    }

    #[test]
    fn paper_values_at_the_rig() {
        // |R| = 0.9975 and angle 3.0550 (section 6.1): the printed values are these at ka = 0.0708, rounded.
        let r = reflection(C64::new(0.0708, 0.0))[0];
        assert_eq!(format!("{:.5} {:.4}", r.norm(), r.arg()), "0.99751 3.0550");
    }
}
