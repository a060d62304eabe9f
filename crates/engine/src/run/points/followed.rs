//! Which mode a prediction is of, and where it is sought at a point where it was not measured.

use super::inputs::conditions;
use crate::{Assembly, Conditions, EngineError, Observed, PointModel};
use rijke_network::Workspace;
use rijke_numerics::{C64, Order, range};
use rijke_study::{Point, Study};
use std::sync::Arc;

/// The longest step along which a mode is followed, as a part of the distance between modes.
const CLOSE: f64 = 0.03;
/// The shortest step from point to point, as a part of the way.
const SHORTEST: f64 = 1.0 / 256.0;

/// The modes that a model was trained on, by their labels.
pub(in crate::run) struct Followed<'a> {
    study: &'a Study,
    seen: Vec<Seen>,
    /// Labels, in the order in which they were met.
    labels: Vec<String>,
    /// For every factor the range of the points at which modes were seen: what else is asked for beside a
    /// point does not count.
    ranges: Vec<f64>,
}

impl<'a> Followed<'a> {
    /// Of what was observed, those at the points that `trained`; all where none of them was observed, none
    /// for a model that no point trained.
    pub(in crate::run) fn of(study: &'a Study, observed: &[Observed], trained: &[String]) -> Self {
        let one = |o: &Observed| Seen {
            label: o.mode.label.clone(),
            near: o.near,
            conditions: o.conditions.clone(),
        };
        let used = |o: &&Observed| trained.contains(&o.conditions.id);
        let mut seen: Vec<Seen> = observed.iter().filter(used).map(one).collect();
        if seen.is_empty() && !trained.is_empty() {
            seen = observed.iter().map(one).collect();
        }
        let mut labels: Vec<String> = Vec::new();
        for mode in &seen {
            if !labels.contains(&mode.label) {
                labels.push(mode.label.clone());
            }
        }
        let width = |k: usize| {
            let all = seen.iter().map(|m| m.conditions.point.factors[k]).filter(|v| v.is_finite());
            let [low, high] = range(all);
            if high > low { high - low } else { 1.0 }
        };
        let ranges = (0..study.campaign.factors.len()).map(width).collect();
        Self { study, seen, labels, ranges }
    }

    /// The modes that are sought under `conditions`, and where: those that the model was trained on, or,
    /// where no mode was ever measured, all that it has in the region of the rig at these `values` of its
    /// parameters, numbered from the lowest frequency.
    ///
    /// # Errors
    /// Those of the model.
    pub(in crate::run) fn sought(
        &self,
        assembly: &Assembly,
        values: &[f64],
        conditions: &Conditions,
    ) -> Result<Vec<Sought>, EngineError> {
        if !self.labels.is_empty() {
            let one = |label: &String| {
                let from = self.nearest(label, conditions);
                let elsewhere = from.filter(|seen| seen.conditions.id != conditions.id);
                let led = elsewhere.map(|seen| self.led(assembly, values, seen, conditions));
                let near = led.flatten().or_else(|| from.map(|seen| seen.scaled_to(conditions)));
                Sought { label: label.clone(), near, lost: led == Some(None) }
            };
            return Ok(self.labels.iter().map(one).collect());
        }
        let mut modes = PointModel::new(assembly, conditions, &[])?.modes(values)?;
        modes.sort_by(|a, b| a.im.total_cmp(&b.im));
        Ok(modes
            .into_iter()
            .zip(1..)
            .map(|(s, k): (C64, usize)| Sought { label: k.to_string(), near: Some(s), lost: false })
            .collect())
    }

    /// Where a mode is sought under `conditions`: where it was measured there, else where it lies at the
    /// nearest point at which it was, its frequency in proportion to that of sound along the rig. None of a
    /// mode that was never seen.
    pub(in crate::run) fn near(&self, label: &str, conditions: &Conditions) -> Option<C64> {
        self.nearest(label, conditions).map(|seen| seen.scaled_to(conditions))
    }

    /// Where the mode of a label arrives under `conditions` when it is followed from the nearest other
    /// point at which it was measured, and that point. None where it cannot be followed.
    pub(in crate::run) fn arrives(
        &self,
        assembly: &Assembly,
        values: &[f64],
        label: &str,
        conditions: &Conditions,
    ) -> Option<(&str, C64)> {
        let elsewhere = self.seen.iter().filter(|m| m.label == label && m.conditions.id != conditions.id);
        let seen =
            elsewhere.min_by(|a, b| self.distance(a, conditions).total_cmp(&self.distance(b, conditions)))?;
        Some((&seen.conditions.id, self.led(assembly, values, seen, conditions)?))
    }

    /// The point at which a mode was measured that is nearest to these conditions.
    fn nearest(&self, label: &str, conditions: &Conditions) -> Option<&Seen> {
        let of_it = || self.seen.iter().filter(|m| m.label == label);
        if let Some(there) = of_it().find(|m| m.conditions.id == conditions.id) {
            return Some(there);
        }
        of_it().min_by(|a, b| self.distance(a, conditions).total_cmp(&self.distance(b, conditions)))
    }

    /// How far a point at which a mode was seen lies from these conditions, squared.
    fn distance(&self, mode: &Seen, conditions: &Conditions) -> f64 {
        let pairs = mode.conditions.point.factors.iter().zip(&conditions.point.factors).zip(&self.ranges);
        let one = |((a, b), range): ((&f64, &f64), &f64)| match (a.is_nan(), b.is_nan()) {
            (false, false) => ((a - b) / range).powi(2),
            (true, true) => 0.0,
            // A part that is there at one of the two points only.
            _ => 4.0,
        };
        pairs.map(one).sum()
    }

    /// Where a mode of the model leads from the point at which it was `seen`, along the straight way between
    /// the factors of both points: in steps so short that it moves by little beside its neighbours. None
    /// where there is no such way, or where the gas of points between is not known.
    fn led(&self, assembly: &Assembly, values: &[f64], seen: &Seen, to: &Conditions) -> Option<C64> {
        let work = &mut Workspace::default();
        let mut root = |conditions: &Conditions, near: C64| {
            let model = PointModel::new(assembly, conditions, &[]).ok()?.starting_from(near);
            let found = model.respond(values, Order::Value, work).ok()?.s.value();
            Some((found, (found - near).norm() / model.spacing()))
        };
        let (mut s, _) = root(&seen.conditions, seen.near)?;
        let (mut at, mut step, mut here) = (0.0, 1.0_f64, travel(&seen.conditions));
        while at < 1.0 {
            let next = (at + step).min(1.0);
            let between;
            let there = if next < 1.0 {
                let point = between_points(&seen.conditions.point, &to.point, next);
                let ambient = point.ambient.or(Some([self.study.rig.temperature, 0.0]));
                between = conditions(self.study, &point, None, ambient).ok()?;
                &between
            } else {
                to
            };
            let time = travel(there);
            match root(there, C64::new(s.re, s.im * here / time)) {
                Some((found, moved)) if moved < CLOSE => {
                    (s, here, at) = (found, time, next);
                    step *= 2.0;
                }
                _ if step > SHORTEST => step *= 0.5,
                _ => return None,
            }
        }
        Some(s)
    }
}

/// A mode that is sought at a point.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::run) struct Sought {
    /// Its label.
    pub(in crate::run) label: String,
    /// Where a search for it begins; the usual place if there is none.
    pub(in crate::run) near: Option<C64>,
    /// Whether it could not be followed from a point where it was measured, so that the search begins where
    /// it lay there.
    pub(in crate::run) lost: bool,
}

/// A mode where it was measured.
struct Seen {
    label: String,
    near: C64,
    conditions: Arc<Conditions>,
}

impl Seen {
    /// Where the mode lies, its frequency in proportion to that of sound along the rig.
    fn scaled_to(&self, conditions: &Conditions) -> C64 {
        C64::new(self.near.re, self.near.im * travel(&self.conditions) / travel(conditions))
    }
}

/// The point that lies so much of the way from one to another.
fn between_points(from: &Point, to: &Point, part: f64) -> Point {
    let mixed = |a: f64, b: f64| if a.is_finite() && b.is_finite() { a + part * (b - a) } else { b };
    let mut point = to.clone();
    point.factors.iter_mut().zip(&from.factors).for_each(|(b, a)| *b = mixed(*a, *b));
    if let (Some([kelvin, _]), Some([before, _])) = (&mut point.ambient, from.ambient) {
        *kelvin = mixed(before, *kelvin);
    }
    point
}

fn travel(conditions: &Conditions) -> f64 {
    conditions.base.travel_time(0.0, conditions.layout.length)
}
