//! What figures of the hot campaign share: one colour per power of the heater, positions along x.

use crate::draw::{Axis, Key, Mark, Stroke, fixed, scale_colour};

/// The powers of a set of points, ascending, each once.
pub(crate) fn powers(all: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut powers: Vec<f64> = all.into_iter().collect();
    powers.sort_by(f64::total_cmp);
    powers.dedup();
    powers
}

/// The colour of each power, in their order.
pub(crate) fn colours(powers: &[f64]) -> impl Iterator<Item = (f64, &'static str)> {
    powers.iter().enumerate().map(|(i, power)| (*power, scale_colour(i, powers.len())))
}

/// A legend with a line per power.
pub(crate) fn legend(powers: &[f64]) -> Vec<Key> {
    let key = |(power, colour): (f64, &'static str)| Key {
        mark: Mark::Line(Stroke::solid(colour, 1.6)),
        label: format!("{} W", fixed(power, 0)),
    };
    colours(powers).map(key).collect()
}

/// Position of the heater.
pub(crate) fn position_axis() -> Axis {
    Axis::new("Heater position *X*_{h} / m", 0.1, 0.9).with_step(0.2)
}

/// Value and sd at the points that are not much less certain than the middle one: what an axis should hold.
pub(crate) fn certain(points: &[[f64; 2]]) -> Vec<f64> {
    let mut sds: Vec<f64> = points.iter().map(|p| p[1]).filter(|sd| sd.is_finite()).collect();
    sds.sort_by(f64::total_cmp);
    let limit = 3.0 * sds.get(sds.len() / 2).copied().unwrap_or(0.0);
    let near = points.iter().filter(|p| p[1] <= limit);
    near.flat_map(|[value, sd]| [value - 2.0 * sd, value + 2.0 * sd]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_uncertain_points_do_not_stretch_the_axis() {
        let held = certain(&[[1.0, 0.1], [2.0, 0.2], [50.0, 40.0], [3.0, 0.2]]);
        assert!(held.iter().all(|v| (0.0..4.0).contains(v)), "{held:?}");
        assert_eq!(powers([15.0, 7.0, 15.0]), [7.0, 15.0]);
    }
}
