//! Axes: a range, ticks at round numbers, a label.

/// At most this many labelled ticks.
const MOST_TICKS: f64 = 6.0;

/// A linear axis.
#[derive(Clone, Debug)]
pub struct Axis {
    /// Label in the markup of [`super::html`].
    pub label: String,
    /// Value at the left or lower end.
    pub low: f64,
    /// Value at the right or upper end.
    pub high: f64,
}

/// Where the ticks are.
pub(crate) struct Ticks {
    /// Labelled ticks.
    pub(crate) major: Vec<f64>,
    /// Ticks between them.
    pub(crate) minor: Vec<f64>,
    /// Decimals of the labels.
    pub(crate) decimals: usize,
}

/// Whether a value can be drawn: neither infinite nor so large that a range or a place would be.
pub(crate) fn is_drawn(value: f64) -> bool {
    value.abs() < 1e100
}

impl Axis {
    /// From `low` to `high`.
    #[must_use]
    pub fn new(label: &str, low: f64, high: f64) -> Self {
        Self { label: label.to_owned(), low, high }
    }

    /// An axis that holds all values that can be drawn with a margin of a twentieth on either side.
    pub fn covering(label: &str, values: impl IntoIterator<Item = f64>) -> Self {
        let drawn = values.into_iter().filter(|v| is_drawn(*v));
        let (low, high) =
            drawn.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        if low > high {
            return Self::new(label, 0.0, 1.0);
        }
        let half = (0.5 * (high - low)).max(1e-9 * (1.0 + low.abs()));
        let middle = 0.5 * (low + high);
        Self::new(label, middle - 1.1 * half, middle + 1.1 * half)
    }

    /// Place of a value between the ends, 0 to 1.
    pub(crate) fn place(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }

    pub(crate) fn ticks(&self) -> Ticks {
        let range = self.high - self.low;
        let step = round_step(range / MOST_TICKS);
        let decimals = (-step.log10()).ceil().max(0.0) as usize;
        // A step of 2.5 or 0.25 needs one decimal more than its size suggests.
        let shown = step * 10f64.powi(decimals as i32);
        let decimals = decimals + usize::from((shown - shown.round()).abs() > 1e-6);
        let pieces = if (mantissa(step) - 2.0).abs() < 1e-6 { 4.0 } else { 5.0 };
        let all: Vec<_> = multiples(step / pieces, self.low, self.high).collect();
        let is_major = |v: f64| ((v / step) - (v / step).round()).abs() < 1e-6;
        Ticks {
            major: all.iter().copied().filter(|&v| is_major(v)).collect(),
            minor: all.iter().copied().filter(|&v| !is_major(v)).collect(),
            decimals,
        }
    }
}

/// The smallest of 1, 2 and 5 times a power of ten that is at least `least`.
pub fn round_step(least: f64) -> f64 {
    let power = 10f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= least * (1.0 - 1e-9)).unwrap_or(least)
}

/// Between 1 and 10.
fn mantissa(step: f64) -> f64 {
    step / 10f64.powf((step.log10() + 1e-9).floor())
}

/// All multiples of a step within a range, ends included.
pub fn multiples(step: f64, low: f64, high: f64) -> impl Iterator<Item = f64> {
    let (first, last) = ((low / step - 1e-6).ceil() as i64, (high / step + 1e-6).floor() as i64);
    (first..=last).map(move |i| i as f64 * step)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn ticks(low: f64, high: f64) -> (Vec<f64>, usize, usize) {
        let ticks = Axis::new("", low, high).ticks();
        (ticks.major, ticks.minor.len(), ticks.decimals)
    }

    #[test]
    fn exact_ticks_are_round_numbers() {
        assert_eq!(ticks(0.0, 1.0), (vec![0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0], 15, 1));
        let (major, _, decimals) = ticks(1057.3, 1071.9);
        assert_eq!((major, decimals), (vec![1060.0, 1065.0, 1070.0], 0));
        let (major, _, decimals) = ticks(0.99511, 0.99542);
        assert_eq!((major.len(), decimals), (3, 4));
    }

    #[test]
    fn exact_covering_leaves_a_margin_and_survives_one_value() {
        let axis = Axis::covering("", [3.0, 1.0, f64::NAN]);
        assert_relative_eq!(axis.low, 0.9, max_relative = 1e-12);
        assert_relative_eq!(axis.high, 3.1, max_relative = 1e-12);
        let axis = Axis::covering("", [2.0]);
        assert!(axis.low < 2.0 && axis.high > 2.0);
    }
}
