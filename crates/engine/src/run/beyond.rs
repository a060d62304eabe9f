//! Points at which the laws of a model are extrapolated.

use crate::SavedModel;
use rijke_study::Study;

/// A factor of a point beyond those of the points that trained a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Beyond {
    /// The point.
    pub point: String,
    /// The factor.
    pub factor: String,
    /// Its value there, SI.
    pub value: f64,
    /// The least and the largest that trained, SI.
    pub trained: [f64; 2],
    /// Its unit in print.
    pub unit: String,
}

impl Beyond {
    /// A sentence without its stop.
    #[must_use]
    pub fn words(&self) -> String {
        let Self { point, factor, value, trained: [low, high], unit } = self;
        format!(
            "{point}: {factor} = {value} {unit} is beyond the points that trained, {low} to {high} {unit}: the laws are extrapolated"
        )
    }
}

/// The factors of the points at `places` of the campaign, but for those of `axes`, that lie beyond those of
/// the points that trained `model`.
#[must_use]
pub fn beyond(study: &Study, model: &SavedModel, places: &[usize], axes: &[usize]) -> Vec<Beyond> {
    let campaign = &study.campaign;
    let trained = |k: usize| {
        let of = |id: &String| campaign.point(id).map(|(_, p)| p.factors[k]).filter(|v| v.is_finite());
        let all = model.trained_on.iter().filter_map(of);
        all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
    };
    let far = |place: &usize| {
        let point = &campaign.points[*place];
        let factors = campaign.factors.iter().enumerate().filter(|(k, _)| !axes.contains(k));
        let found = factors.filter_map(move |(k, factor)| {
            let (range, value) = (trained(k), point.factors[k]);
            is_beyond(value, range).then(|| Beyond {
                point: point.id.clone(),
                factor: factor.name.clone(),
                value,
                trained: range,
                unit: factor.unit_in_print(),
            })
        });
        found.collect::<Vec<_>>()
    };
    places.iter().flat_map(far).collect()
}

/// Beyond by more than rounding; where nothing trained nothing is beyond.
fn is_beyond(value: f64, [low, high]: [f64; 2]) -> bool {
    let room = 1e-9 * (high - low).abs().max(high.abs());
    value.is_finite() && low <= high && !(low - room..=high + room).contains(&value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_only_what_lies_outside_by_more_than_rounding_is_extrapolated() {
        assert!(!is_beyond(0.3, [0.1, 0.3]) && !is_beyond(0.1 + 0.2, [0.1, 0.3]));
        assert!(is_beyond(0.31, [0.1, 0.3]) && is_beyond(0.0, [0.1, 0.3]));
        assert!(!is_beyond(f64::NAN, [0.1, 0.3]) && !is_beyond(1.0, [f64::INFINITY, f64::NEG_INFINITY]));
        let beyond = Beyond {
            point: "a".into(),
            factor: "Q".into(),
            value: 60.0,
            trained: [0.0, 50.0],
            unit: "W".into(),
        };
        assert!(beyond.words().starts_with("a: Q = 60 W is beyond the points that trained, 0 to 50 W"));
    }
}
