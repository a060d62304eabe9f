//! Smallest and largest of several numbers.

/// The smallest and the largest of several numbers; infinite, and the wrong way round, if there are none.
/// NaN is passed over.
#[must_use]
pub fn range(numbers: impl IntoIterator<Item = f64>) -> [f64; 2] {
    numbers.into_iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
}

#[cfg(test)]
mod tests {
    use super::range;

    #[test]
    fn exact_ranges_pass_over_what_is_no_number() {
        assert_eq!(range([2.0, f64::NAN, -1.0]), [-1.0, 2.0]);
        let [low, high] = range([]);
        assert!(low > high);
    }
}
