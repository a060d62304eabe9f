//! Which mode a prediction is of, and where it is sought at a point where it was not measured.

use crate::{Assembly, Conditions, EngineError, Observed, PointModel};
use rijke_numerics::C64;
use rijke_study::Study;

/// A mode where it was measured.
struct Seen {
    label: String,
    point: String,
    factors: Vec<f64>,
    near: C64,
    /// Time that sound needs along the rig there, s.
    travel: f64,
}

/// The modes that a model was trained on, by their labels.
pub(super) struct Followed {
    seen: Vec<Seen>,
    /// Labels, in the order in which they were met.
    labels: Vec<String>,
    /// For every factor the range of the points at which modes were seen: what else is asked for beside a
    /// point does not count.
    ranges: Vec<f64>,
}

impl Followed {
    /// Of what was observed, those at the points that `trained`; all where none of them was observed, none
    /// for a model that no point trained.
    pub(super) fn of(study: &Study, observed: &[Observed], trained: &[String]) -> Self {
        let one = |o: &Observed| Seen {
            label: o.mode.label.clone(),
            point: o.conditions.id.clone(),
            factors: o.conditions.point.factors.clone(),
            near: o.near,
            travel: travel(&o.conditions),
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
        let range = |k: usize| {
            let all = seen.iter().map(|m| m.factors[k]).filter(|v| v.is_finite());
            let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
            if high > low { high - low } else { 1.0 }
        };
        let ranges = (0..study.campaign.factors.len()).map(range).collect();
        Self { seen, labels, ranges }
    }

    /// The modes that are sought under `conditions`, and where: those that the model was trained on, or,
    /// where no mode was ever measured, all that it has in the region of the rig at these `values` of its
    /// parameters, numbered from the lowest frequency.
    ///
    /// # Errors
    /// Those of the model.
    pub(super) fn sought(
        &self,
        assembly: &Assembly,
        values: &[f64],
        conditions: &Conditions,
    ) -> Result<Vec<(String, Option<C64>)>, EngineError> {
        if !self.labels.is_empty() {
            return Ok(self
                .labels
                .iter()
                .map(|label| (label.clone(), self.near(label, conditions)))
                .collect());
        }
        let mut modes = PointModel::new(assembly, conditions, &[])?.modes(values)?;
        modes.sort_by(|a, b| a.im.total_cmp(&b.im));
        Ok(modes.into_iter().zip(1..).map(|(s, k)| (k.to_string(), Some(s))).collect())
    }

    /// The labels of the modes.
    pub(super) fn labels(&self) -> &[String] {
        &self.labels
    }

    /// Where a mode is sought under `conditions`: where it was measured there, else where it lies at the
    /// nearest point at which it was, its frequency in proportion to that of sound along the rig. None of a
    /// mode that was never seen.
    pub(super) fn near(&self, label: &str, conditions: &Conditions) -> Option<C64> {
        let of_it = || self.seen.iter().filter(|m| m.label == label);
        if let Some(there) = of_it().find(|m| m.point == conditions.id) {
            return Some(there.near);
        }
        let distance = |mode: &Seen| -> f64 {
            let pairs = mode.factors.iter().zip(&conditions.point.factors).zip(&self.ranges);
            let one = |((a, b), range): ((&f64, &f64), &f64)| match (a.is_nan(), b.is_nan()) {
                (false, false) => ((a - b) / range).powi(2),
                (true, true) => 0.0,
                // A part that is there at one of the two points only.
                _ => 4.0,
            };
            pairs.map(one).sum()
        };
        let nearest = of_it().min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        Some(C64::new(nearest.near.re, nearest.near.im * nearest.travel / travel(conditions)))
    }
}

fn travel(conditions: &Conditions) -> f64 {
    conditions.base.travel_time(0.0, conditions.layout.length)
}
