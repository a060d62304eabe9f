//! Points at which the laws of a model are extrapolated.

use super::elsewhere::T_AMB;
use rijke_numerics::range;
use rijke_numerics::words::to_digits;
use rijke_study::{Point, Study, unit_behind};

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
    /// The part that it puts into the rig, which was at no point that trained.
    pub part: Option<String>,
}

impl Beyond {
    /// A sentence without its stop.
    #[must_use]
    pub fn words(&self) -> String {
        let Self { point, factor, unit, part, .. } = self;
        let [value, low, high] = [self.value, self.trained[0], self.trained[1]].map(|v| to_digits(v, 6));
        let unit = unit_behind(unit);
        match part {
            Some(part) => format!(
                "{point}: {part} is present ({factor} = {value}) but was absent at all points that trained: it acts as rig.toml and the laws of this \
                 model describe it, untested by these data"
            ),
            None => format!(
                "{point}: {factor} = {value}{unit} is beyond the points that trained, {low} to {high}{unit}: the laws are extrapolated"
            ),
        }
    }
}

/// How far the ambient temperature may lie from all that trained, K: that of another season. The sound speed
/// differs by 2 % then, which every law has in its gas.
const SEASON: f64 = 10.0;

/// The factors of the points at `places` of the campaign, but for those of `axes`, that lie beyond those of
/// the points that trained, `trained_on`, and ambient temperatures that lie far from these.
#[must_use]
pub fn beyond(study: &Study, trained_on: &[String], places: &[usize], axes: &[usize]) -> Vec<Beyond> {
    let campaign = &study.campaign;
    let trained = |of: &dyn Fn(&Point) -> Option<f64>| {
        let points = trained_on.iter().filter_map(|id| campaign.point(id));
        range(points.filter_map(|(_, point)| of(point)).filter(|v| v.is_finite()))
    };
    let rig = &study.rig;
    let brought = |k: usize| rig.parts.iter().find(|p| rig.presence(p) == Some(k)).map(|p| p.name.clone());
    let ambient = |point: &Point| point.ambient.map(|[value, _]| value);
    let far = |place: &usize| {
        let point = &campaign.points[*place];
        let factors = campaign.factors.iter().enumerate().filter(|(k, _)| !axes.contains(k));
        let found = factors.filter_map(move |(k, factor)| {
            let (range, value) = (trained(&|p| Some(p.factors[k])), point.factors[k]);
            is_beyond(value, range).then(|| Beyond {
                point: point.id.clone(),
                factor: factor.name.clone(),
                value,
                trained: range,
                unit: factor.unit_in_print(),
                part: brought(k).filter(|_| range[1] <= 0.0 && value > 0.0),
            })
        });
        let [low, high] = trained(&ambient);
        let outside = |value: &f64| is_beyond(*value, [low - SEASON, high + SEASON]);
        let warmer = ambient(point).filter(outside).map(|value| Beyond {
            point: point.id.clone(),
            factor: T_AMB.into(),
            value,
            trained: [low, high],
            unit: "K".into(),
            part: None,
        });
        found.chain(warmer).collect::<Vec<_>>()
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
            part: None,
        };
        assert!(beyond.words().starts_with("a: Q = 60 W is beyond the points that trained, 0 to 50 W"));
        let damper = Beyond { part: Some("damper".into()), ..beyond };
        assert!(
            damper
                .words()
                .starts_with("a: damper is present (Q = 60) but was absent at all points that trained")
        );
    }
}
