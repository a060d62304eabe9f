//! Sums of numbers of which only the logarithms can be written.

/// The share of each number in the sum of all, by their logarithms, and ln of that sum. A logarithm that is
/// not finite counts as that of zero.
pub(crate) fn shares(ln: &[f64]) -> (Vec<f64>, f64) {
    let largest = ln.iter().copied().filter(|ln| ln.is_finite()).fold(f64::NEG_INFINITY, f64::max);
    let weight = |ln: &f64| if ln.is_finite() { (ln - largest).exp() } else { 0.0 };
    let sum: f64 = ln.iter().map(weight).sum();
    (ln.iter().map(|ln| weight(ln) / sum.max(f64::MIN_POSITIVE)).collect(), largest + sum.ln())
}
