//! Chi-squared in standard deviations, where its probability is far below the smallest number.

use std::f64::consts::{PI, SQRT_2};

/// The number x of standard deviations that a normal number exceeds, on either side, with the probability
/// that a chi-squared of `freedom` degrees exceeds `chi_squared`. The square root of `chi_squared` for one
/// degree; finite for any finite argument.
#[must_use]
pub fn chi_squared_sds(chi_squared: f64, freedom: usize) -> f64 {
    if freedom == 0 || chi_squared.is_nan() || chi_squared <= 0.0 {
        return 0.0;
    }
    if freedom == 1 {
        return chi_squared.sqrt();
    }
    let ln_p = ln_upper_gamma(0.5 * freedom as f64, 0.5 * chi_squared);
    // Newton on the logarithm of the tail, which is concave, from a point to the right of the root.
    let mut x = (-2.0 * ln_p).max(0.0).sqrt();
    for _ in 0..60 {
        let (ln_tail, hazard) = ln_two_tails(x);
        let step = (ln_p - ln_tail) / hazard;
        x = (x - step).max(0.0);
        if step.abs() <= 1e-14 * x.max(1e-3) {
            break;
        }
    }
    x
}

/// ln of the probability that a normal number lies further out than `x` on either side, and minus its
/// derivative.
fn ln_two_tails(x: f64) -> (f64, f64) {
    let ln_density = -0.5 * x * x + 0.5 * (2.0 / PI).ln();
    let ln_tail = if x < 20.0 {
        libm::erfc(x / SQRT_2).ln()
    } else {
        // Abramowitz & Stegun 7.1.23; the next term is 105/x^8 < 1e-8.
        let y = 1.0 / (x * x);
        ln_density - x.ln() + (-y + 3.0 * y * y - 15.0 * y * y * y).ln_1p()
    };
    (ln_tail, (ln_density - ln_tail).exp())
}

/// ln of the regularised upper incomplete gamma function Q(a, x): series below a + 1, continued fraction
/// above (Press et al., section 6.2).
fn ln_upper_gamma(a: f64, x: f64) -> f64 {
    let front = -x + a * x.ln() - libm::lgamma(a);
    if x < a + 1.0 {
        let (mut term, mut sum, mut k) = (1.0 / a, 1.0 / a, a);
        while term > 1e-17 * sum {
            k += 1.0;
            term *= x / k;
            sum += term;
        }
        return (-(front + sum.ln()).exp()).ln_1p();
    }
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (f64::INFINITY, 1.0 / b);
    let mut h = d;
    for i in 1..100_000 {
        let i = f64::from(i);
        let an = -i * (i - a);
        b += 2.0;
        d = 1.0 / (an * d + b);
        c = b + an / c;
        h *= d * c;
        if (d * c - 1.0).abs() < 1e-15 {
            break;
        }
    }
    front + h.ln()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::normal_quantile;

    #[test]
    fn oracle_tables_of_chi_squared() {
        // Abramowitz & Stegun, table 26.8: exceeded with probability 0.05 and 0.001.
        for (freedom, chi_squared, p) in
            [(2, 5.991_46, 0.05), (3, 7.814_73, 0.05), (10, 29.588, 0.001), (30, 43.772_9, 0.05)]
        {
            let x = chi_squared_sds(chi_squared, freedom);
            assert!((x + normal_quantile(0.5 * p)).abs() < 2e-4, "{freedom}: {x}");
        }
    }

    #[test]
    fn exact_two_degrees_have_an_exponential_tail_at_any_distance() {
        // Q(1, x) = e^-x; the normal tail by its own logarithm.
        for chi_squared in [0.1, 1.0, 30.0, 400.0, 2600.0, 1e6, 1e12] {
            let x = chi_squared_sds(chi_squared, 2);
            let ln_p = ln_two_tails(x).0;
            assert!((ln_p / (-0.5 * chi_squared) - 1.0).abs() < 1e-10, "{chi_squared}: {x} {ln_p}");
        }
        // A chi-squared of even degree: Q(2, x) = (1 + x) e^-x.
        let x: f64 = 700.0;
        assert!((ln_upper_gamma(2.0, x) - (x.ln_1p() - x)).abs() < 1e-10);
        assert_eq!(
            (chi_squared_sds(0.0, 3), chi_squared_sds(9.0, 1), chi_squared_sds(5.0, 0)),
            (0.0, 3.0, 0.0)
        );
    }

    #[test]
    fn exact_both_forms_of_the_tail_meet() {
        let (near, far) = (ln_two_tails(20.0 - 1e-9).0, ln_two_tails(20.0 + 1e-9).0);
        assert!((near - far).abs() < 1e-6, "{near} {far}");
    }
}
