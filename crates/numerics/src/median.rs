//! The number in the middle.

/// The median of some numbers, the mean of the two in the middle if their count is even; NaN of none.
#[must_use]
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    if n == 0 { f64::NAN } else { 0.5 * (values[(n - 1) / 2] + values[n / 2]) }
}

#[cfg(test)]
mod tests {
    use super::median;

    #[test]
    fn exact_half_of_the_numbers_lie_on_each_side() {
        assert_eq!(median(vec![3.0, -1.0, 2.0]), 2.0);
        assert_eq!(median(vec![4.0, 1.0, -8.0, 2.0]), 1.5);
        assert!(median(Vec::new()).is_nan());
    }
}
