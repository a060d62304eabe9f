//! Axes: a range, ticks at round numbers, a label.

use super::text::fixed;

/// Pixels between labels of ticks side by side, at least.
const GAP: f64 = 8.0;

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
    /// Names of the whole numbers from 0 on, where the axis counts things; else empty.
    names: Vec<String>,
}

/// Where the ticks are.
pub(crate) struct Ticks {
    /// Labelled ticks.
    pub(crate) major: Vec<f64>,
    /// Ticks between them.
    pub(crate) minor: Vec<f64>,
    /// Labels of the labelled ticks.
    pub(crate) labels: Vec<String>,
}

/// Whether a value can be drawn: neither infinite nor so large that a range or a place would be.
pub(crate) fn is_drawn(value: f64) -> bool {
    value.abs() < 1e100
}

impl Axis {
    /// From `low` to `high`.
    #[must_use]
    pub fn new(label: &str, low: f64, high: f64) -> Self {
        Self { label: label.to_owned(), low, high, names: Vec::new() }
    }

    /// An axis of things with names, of which the first stands at 0, the second at 1.
    #[must_use]
    pub fn named(label: &str, names: &[String]) -> Self {
        Self { names: names.to_vec(), ..Self::new(label, -0.5, names.len() as f64 - 0.5) }
    }

    /// An axis that holds all values that can be drawn with a margin of a twentieth on either side. One
    /// value, or several that are the same but for rounding, has a tenth of itself on either side.
    pub fn covering(label: &str, values: impl IntoIterator<Item = f64>) -> Self {
        let drawn = values.into_iter().filter(|v| is_drawn(*v));
        let (low, high) =
            drawn.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        if low > high {
            return Self::new(label, 0.0, 1.0);
        }
        let (half, middle) = (0.5 * (high - low), 0.5 * (low + high));
        let half = match half > 1e-9 * low.abs().max(high.abs()) {
            true => half,
            false if middle.abs() > 0.0 => 0.1 * middle.abs(),
            false => 1.0,
        };
        Self::new(label, middle - 1.1 * half, middle + 1.1 * half)
    }

    /// Place of a value between the ends, 0 to 1.
    pub(crate) fn place(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }

    /// Ticks as many as look well.
    pub(crate) fn ticks(&self) -> Ticks {
        self.ticks_every(round_step((self.high - self.low) / MOST_TICKS))
    }

    /// The same, but no more than have room for labels side by side on an axis of `long` pixels. `wide` is
    /// the width of a label.
    pub(crate) fn ticks_within(&self, long: f64, wide: impl Fn(&str) -> f64) -> Ticks {
        let range = self.high - self.low;
        let mut step = if self.names.is_empty() { round_step(range / MOST_TICKS) } else { 1.0 };
        loop {
            let ticks = self.ticks_every(step);
            let widest = ticks.labels.iter().map(|label| wide(label)).fold(0.0, f64::max);
            if ticks.major.len() < 3 || widest + GAP <= long * step / range {
                return ticks;
            }
            step = round_step(1.5 * step);
        }
    }

    fn ticks_every(&self, step: f64) -> Ticks {
        if !self.names.is_empty() {
            let major: Vec<f64> = multiples(step, self.low, self.high).collect();
            let labels = major.iter().filter_map(|v| self.names.get(*v as usize).cloned()).collect();
            return Ticks { major, minor: Vec::new(), labels };
        }
        let decimals = (-step.log10()).ceil().max(0.0) as usize;
        // A step of 2.5 or 0.25 needs one decimal more than its size suggests.
        let shown = step * 10f64.powi(decimals as i32);
        let decimals = decimals + usize::from((shown - shown.round()).abs() > 1e-6);
        let pieces = if (mantissa(step) - 2.0).abs() < 1e-6 { 4.0 } else { 5.0 };
        let all: Vec<_> = multiples(step / pieces, self.low, self.high).collect();
        let is_major = |v: f64| ((v / step) - (v / step).round()).abs() < 1e-6;
        let (major, minor): (Vec<f64>, Vec<f64>) = all.into_iter().partition(|&v| is_major(v));
        let labels = major.iter().map(|v| fixed(*v, decimals)).collect();
        Ticks { major, minor, labels }
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
        let decimals = ticks.labels[0].split_once('.').map_or(0, |(_, after)| after.len());
        (ticks.major, ticks.minor.len(), decimals)
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
        assert!(axis.low < 1.8 && axis.high > 2.2, "a dot at one place has room on both sides");
        let axis = Axis::covering("", [0.25, 0.25 + 1e-16]);
        assert!(axis.high - axis.low > 0.05, "rounding is no range: {axis:?}");
        assert_eq!(Axis::covering("", [0.0]).high, 1.1);
    }

    #[test]
    fn exact_labels_of_ticks_do_not_overlap() {
        let axis = Axis::new("", 0.249_999_9, 0.250_000_1);
        let wide = |label: &str| 9.0 * label.len() as f64;
        let ticks = axis.ticks_within(340.0, wide);
        let step = ticks.major[1] - ticks.major[0];
        let room = 340.0 * step / (axis.high - axis.low);
        assert!(ticks.major.len() >= 2 && wide(&ticks.labels[0]) < room, "{:?}", ticks.major);
        assert!(ticks.major.len() < axis.ticks().major.len());
        assert_eq!(Axis::new("", 0.0, 1.0).ticks_within(340.0, wide).major.len(), 6);
    }
}
