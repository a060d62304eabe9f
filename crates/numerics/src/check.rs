//! Checkers of derivatives and of convergence, for tests.

/// Local slopes d ln(remainder) / d ln(h) of a Taylor remainder, for h = 1e-2, 5e-3, ... over six halvings.
///
/// `remainder(h)` is |f(x + h d) - Taylor polynomial|. A first-order polynomial gives slopes near 2, a
/// second-order one near 3. Remainders that reach rounding are left out, so the list may be shorter.
pub fn remainder_slopes(remainder: impl Fn(f64) -> f64) -> Vec<f64> {
    slopes_from(1e-2, remainder)
}

/// As [`remainder_slopes`], starting from the step `first`, for variables that are not of order one.
pub fn slopes_from(first: f64, remainder: impl Fn(f64) -> f64) -> Vec<f64> {
    let values: Vec<f64> = (0..7).map(|k| remainder(first / f64::from(1 << k))).collect();
    values.windows(2).filter(|w| w[1] > 0.0).map(|w| (w[0] / w[1]).log2()).collect()
}

/// Panics with the whole table unless the last three slopes lie within `tolerance` of `expected`.
///
/// # Panics
/// That is its purpose: call it from tests only.
#[track_caller]
#[allow(clippy::panic, reason = "an assertion for tests")]
pub fn slopes_near(slopes: &[f64], expected: f64, tolerance: f64) {
    let last = &slopes[slopes.len().saturating_sub(3)..];
    if last.len() < 3 || last.iter().any(|s| (s - expected).abs() > tolerance) {
        panic!("expected slopes {expected} +- {tolerance}, found {slopes:.4?}");
    }
}
