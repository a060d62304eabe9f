//! The normal distribution function and its inverse.

use std::f64::consts::{PI, SQRT_2};

/// Probability that a standard normal number is below `x`; relative accuracy near rounding in both tails.
#[must_use]
pub fn normal_cdf(x: f64) -> f64 {
    0.5 * libm::erfc(-x / SQRT_2)
}

/// The number below which a standard normal number lies with probability `p`; infinite at 0 and 1, NaN
/// outside.
///
/// Starts from the tail expansion or the centre and applies Halley's iteration to ln of the tail probability
/// until the step is at rounding; at most 60 steps, in practice under ten.
#[must_use]
pub fn normal_quantile(p: f64) -> f64 {
    if !(0.0..=1.0).contains(&p) {
        return f64::NAN;
    }
    if p > 0.5 {
        return -normal_quantile(1.0 - p);
    }
    if p == 0.0 {
        return f64::NEG_INFINITY;
    }
    // ln of the lower tail is concave in x, so Newton on it from the left converges without overshoot.
    let mut x = -(-2.0 * (2.0 * p).ln()).max(0.0).sqrt();
    for _ in 0..60 {
        let tail = normal_cdf(x);
        let hazard = (-0.5 * x * x).exp() / (2.0 * PI).sqrt() / tail;
        let error = (tail / p).ln();
        // Derivatives of ln cdf: h and -h (x + h).
        let step = error / (hazard + 0.5 * error * (x + hazard));
        x -= step;
        if step.abs() <= 1e-15 * x.abs().max(1e-3) {
            break;
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn oracle_tables_of_the_normal_distribution() {
        // Abramowitz & Stegun, table 26.1 and 26.5, and mpmath at 30 digits.
        assert_relative_eq!(normal_cdf(1.0), 0.841_344_746_068_542_9, max_relative = 1e-15);
        assert_relative_eq!(normal_cdf(-10.0), 7.619_853_024_160_527e-24, max_relative = 1e-13);
        assert_relative_eq!(normal_quantile(0.975), 1.959_963_984_540_054, max_relative = 1e-14);
    }

    #[test]
    fn exact_quantile_inverts_the_distribution() {
        for exponent in 1..300 {
            let p = 10_f64.powi(-exponent);
            assert_relative_eq!(normal_cdf(normal_quantile(p)), p, max_relative = 1e-11);
        }
        for k in 1..100 {
            let p = f64::from(k) / 100.0;
            assert_relative_eq!(normal_cdf(normal_quantile(p)), p, max_relative = 1e-14);
        }
        assert!(normal_quantile(-0.1).is_nan() && normal_quantile(f64::NAN).is_nan());
    }
}
