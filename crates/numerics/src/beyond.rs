//! How much residuals scatter beyond their own errors.

/// Relative error of the variance.
const CLOSE: f64 = 1e-6;

/// The variance that, added to the error of each, makes the residuals as large as they should be: the sum of
/// their squares over their variances is their number (Paule and Mandel, J. Res. Natl. Bur. Stand. 87 (1982)
/// 377). `each` holds squares of residuals and of their errors; 0 where the errors alone explain them.
///
/// With equal errors it is the mean of the squares less the error's; with unequal ones the mean of the
/// squares would be that of the least precise.
#[must_use]
pub fn scatter_beyond(each: &[[f64; 2]]) -> f64 {
    let over = |variance: f64| {
        let of = |[square, error]: &[f64; 2]| if *square > 0.0 { square / (error + variance) } else { 0.0 };
        each.iter().map(of).sum::<f64>()
    };
    let (count, squares) = (each.len() as f64, each.iter().map(|[square, _]| square).sum::<f64>());
    if !squares.is_finite() || over(0.0) <= count {
        return 0.0;
    }
    // Without errors it would be the mean of the squares, which is the most that it can be.
    let (mut low, mut high) = (0.0, squares / count);
    while high - low > CLOSE * high {
        let middle = if low > 0.0 { low.sqrt() * high.sqrt() } else { 1e-4 * high };
        // So small a variance is none.
        if middle < f64::MIN_POSITIVE {
            return 0.0;
        }
        if over(middle) > count { low = middle } else { high = middle }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::scatter_beyond;

    #[test]
    fn exact_the_scatter_beyond_equal_errors_is_that_of_their_squares() {
        let each = [4.0, 1.0, 9.0, 2.0].map(|square| [square, 0.5]);
        assert!((scatter_beyond(&each) - 3.5).abs() < 1e-5);
        assert_eq!(scatter_beyond(&each.map(|[square, _]| [square, 5.0])), 0.0);
        // Without errors, and of nothing.
        assert!((scatter_beyond(&each.map(|[square, _]| [square, 0.0])) - 4.0).abs() < 1e-5);
        assert_eq!((scatter_beyond(&[]), scatter_beyond(&[[0.0, 0.0]])), (0.0, 0.0));
        assert_eq!(scatter_beyond(&[[f64::INFINITY, 1.0]]), 0.0);
    }

    #[test]
    fn exact_the_least_precise_do_not_decide() {
        // Ten residuals of 0.1 with errors of 0.001, and one of 3 with an error of 3: the scatter is 0.1.
        let mut each = vec![[0.01, 1e-6]; 10];
        each.push([9.0, 9.0]);
        let found = scatter_beyond(&each);
        let over: f64 = each.iter().map(|[square, error]| square / (error + found)).sum();
        assert!((over - 11.0).abs() < 1e-4 && (found - 0.01).abs() < 1e-4, "{over} {found}");
    }
}
