//! Numbers in print.

/// A value with its standard deviation in the last two digits: 1.0109(18).
pub(crate) fn with_uncertainty(value: f64, sd: f64) -> String {
    if !(sd > 0.0 && sd.is_finite() && value.is_finite()) {
        return format!("{value:.4e}");
    }
    let digits = 1 - sd.log10().floor() as i32;
    let largest = value.abs().max(sd).log10().floor() as i32;
    if (-4..=5).contains(&largest) && (0..=9).contains(&digits) {
        let digits = digits as usize;
        return format!("{value:.digits$}({:.0})", sd * 10f64.powi(digits as i32)).replace('-', "\u{2212}");
    }
    let scale = 10f64.powi(largest);
    let shown = (digits + largest).max(0) as usize;
    let text = format!("{:.shown$}({:.0})", value / scale, sd / scale * 10f64.powi(shown as i32));
    format!("{} × 10<sup>{largest}</sup>", text.replace('-', "\u{2212}")).replace("<sup>-", "<sup>\u{2212}")
}

/// A size in print, with two digits that count.
pub(super) fn two_digits(value: f64) -> String {
    if !(value > 0.0 && value.is_finite()) {
        return format!("{value}");
    }
    let digits = (1 - value.log10().floor() as i32).clamp(0, 9) as usize;
    format!("{value:.digits$}")
}

/// A size in print, with three digits that count, however small it is.
pub(super) fn three_digits(value: f64) -> String {
    if !(value > 0.0 && value.is_finite()) {
        return format!("{value}");
    }
    let power = value.log10().floor() as i32;
    match power {
        -4..=9 => {
            let digits = (2 - power).max(0) as usize;
            format!("{value:.digits$}")
        }
        _ => format!("{:.2} \u{d7} 10<sup>{power}</sup>", value / 10f64.powi(power)).replace('-', "\u{2212}"),
    }
}

/// A probability in print.
pub(super) fn chance(p: f64) -> String {
    if p < 5e-4 { "&lt; 0.001".to_owned() } else { format!("{p:.3}") }
}

#[cfg(test)]
mod tests {
    use super::{three_digits, two_digits, with_uncertainty};

    #[test]
    fn exact_two_digits_count() {
        assert_eq!([0.0312, 4.26, 87.4, 1234.0].map(two_digits), ["0.031", "4.3", "87", "1234"]);
    }

    #[test]
    fn exact_small_misfits_have_digits_too() {
        assert_eq!(three_digits(5.354e-5), "5.35 \u{d7} 10<sup>\u{2212}5</sup>");
        assert_eq!(
            [0.0, 0.000_535_4, 0.1, 12.34, 1234.0].map(three_digits),
            ["0", "0.000535", "0.100", "12.3", "1234"]
        );
    }

    #[test]
    fn exact_the_last_two_digits_are_the_uncertain_ones() {
        assert_eq!(with_uncertainty(1.01093, 0.0018), "1.0109(18)");
        assert_eq!(with_uncertainty(-55.31, 0.12), "\u{2212}55.31(12)");
        assert_eq!(with_uncertainty(0.0004, 2.1e-6), "0.0004000(21)");
        assert_eq!(with_uncertainty(1.6e-7, 2e-9), "1.600(20) × 10<sup>\u{2212}7</sup>");
    }
}
