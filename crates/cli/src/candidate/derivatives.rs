//! Whether the derivatives of a law are those of its formula: difference quotients, and the order of the Taylor remainder.

use super::S;
use rijke_numerics::{C64, Jet, check::slopes_from};

/// Largest relative difference between a derivative and a difference quotient of step 1e-5: the quotient's own error is
/// some 1e-10 by curvature and 1e-11 by rounding, more only where a law is nearly singular.
pub(super) const TOLERANCE: f64 = 1e-6;

/// Step of the difference quotients, relative to the parameter or to s.
const STEP: f64 = 1e-5;

/// The remainder of a Taylor polynomial with two derivatives falls as the third power of the step; with a wrong Hessian it would
/// fall as the second, with a wrong gradient as the first.
pub(super) const LEAST_SLOPE: f64 = 2.5;

/// Largest relative step of the Taylor polynomial; six halvings follow.
const FIRST: f64 = 1e-2;

/// Remainders smaller than this, relative to the law, are rounding.
const ROUNDING: f64 = 1e-12;

/// Relative errors of gradient and Hessian, and how far the law is from analytic in s.
pub(super) fn errors(jet: &Jet, values: &[f64], at: &impl Fn(&[f64], C64) -> Jet) -> [f64; 3] {
    let n = values.len();
    // Central difference along one seed; s is the last, along the real axis or the imaginary.
    let sides = |k: usize, across: bool| {
        let h = STEP * if k < n { values[k].abs().max(1e-12) } else { S.norm() };
        let side = |sign: f64| {
            let mut moved = values.to_vec();
            let mut s = S;
            match (k < n, across) {
                (true, _) => moved[k] += sign * h,
                (false, false) => s += sign * h,
                (false, true) => s += C64::new(0.0, sign * h),
            }
            at(&moved, s)
        };
        let direction = if across { C64::I } else { C64::ONE };
        (side(1.0), side(-1.0), direction * (2.0 * h), h)
    };
    let mut errors = [0.0f64; 3];
    for k in 0..=n {
        let (up, down, twice, h) = sides(k, false);
        let quotient = (up.value() - down.value()) / twice;
        let floor = natural(jet.value(), h);
        let size = |v: C64| v.norm().max(floor);
        errors[0] = errors[0].max((quotient - jet.gradient()[k]).norm() / size(jet.gradient()[k]));
        for j in 0..=n {
            let quotient = (up.gradient()[j] - down.gradient()[j]) / twice;
            let floor = natural(jet.gradient()[j], h);
            let exact = jet.hessian(j.min(k), j.max(k));
            errors[1] = errors[1].max((quotient - exact).norm() / exact.norm().max(floor));
        }
    }
    let (up, down, twice, h) = sides(n, true);
    let across = (up.value() - down.value()) / twice;
    let floor = natural(jet.value(), h);
    errors[2] = (across - jet.gradient()[n]).norm() / jet.gradient()[n].norm().max(floor);
    errors
}

/// The order of the remainder of the Taylor polynomial with gradient and Hessian, along one direction of all parameters and s
/// together; none if the polynomial is the law itself.
pub(super) fn taylor_slope(jet: &Jet, values: &[f64], at: &impl Fn(&[f64], C64) -> Jet) -> Option<f64> {
    let n = values.len();
    let direction = |k: usize| if k < n { C64::new(values[k], 0.0) } else { S * C64::new(0.6, 0.8) };
    let first: C64 = (0..=n).map(|k| jet.gradient()[k] * direction(k)).sum();
    let row = |j: usize| -> C64 { (0..=n).map(|k| jet.hessian(j.min(k), j.max(k)) * direction(k)).sum() };
    let second: C64 = (0..=n).map(|j| row(j) * direction(j)).sum();
    let slopes = slopes_from(FIRST, |h| {
        let moved: Vec<f64> = values.iter().map(|v| v + h * v).collect();
        let remainder =
            at(&moved, S + direction(n) * h).value() - (jet.value() + first * h + second * (0.5 * h * h));
        Some(remainder.norm()).filter(|r| *r > ROUNDING * jet.value().norm()).unwrap_or(0.0)
    });
    slopes.last().copied()
}

/// The slope of a quantity that changes by itself over a step of relative size one: derivatives are judged against it where
/// they are smaller, because rounding of the quantity limits its quotients.
fn natural(value: C64, step: f64) -> f64 {
    STEP * value.norm() / step + f64::MIN_POSITIVE
}

#[cfg(test)]
mod tests {
    use super::*;
    use rijke_numerics::{JetSpace, Order};

    /// exp(-a s) b with its derivatives, and with one of them spoilt.
    fn law(values: &[f64], s: C64) -> Jet {
        let space = JetSpace::new(3, Order::Second);
        let [a, b] = [0, 1].map(|k| space.seed(k, C64::new(values[k], 0.0)));
        &(&a * &space.seed(2, s)).scale(C64::new(-1.0, 0.0)).exp() * &b
    }

    #[test]
    fn order_the_remainder_tells_which_derivative_is_wrong() {
        let values = [4e-4, 0.7];
        let slope = |jet: &Jet| taylor_slope(jet, &values, &law).unwrap();
        let right = law(&values, S);
        assert!((slope(&right) - 3.0).abs() < 0.02, "{}", slope(&right));
        // Derivatives of another function with the same value: its Hessian alone differs, then its gradient too.
        let space = JetSpace::new(3, Order::Second);
        let b = space.seed(1, C64::new(values[1], 0.0));
        let bent = &right + &(&b - &space.real(values[1])).powi(2).scale(C64::new(1e-2, 0.0));
        assert!((slope(&bent) - 2.0).abs() < 0.1, "{}", slope(&bent));
        let tilted = &right + &(&b - &space.real(values[1])).scale(C64::new(1e-2, 0.0));
        assert!((slope(&tilted) - 1.0).abs() < 0.1, "{}", slope(&tilted));
        assert!(slope(&bent) < LEAST_SLOPE && slope(&tilted) < LEAST_SLOPE);
        // A polynomial of second degree is its own.
        let square = |values: &[f64], _: C64| {
            let space = JetSpace::new(3, Order::Second);
            space.seed(1, C64::new(values[1], 0.0)).powi(2)
        };
        assert_eq!(taylor_slope(&square(&values, S), &values, &square), None);
    }
}
