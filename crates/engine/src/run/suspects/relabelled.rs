//! Modes whose labels jump from one to another between operating points.

use super::super::course::{Chosen, Run};
use super::super::points::followed::Followed;
use rijke_numerics::C64;
use std::collections::BTreeSet;

/// How far a mode that was followed may end from one that was measured, relative to its size, to be that
/// one: errors of the gas that were inferred along move it.
const SAME: f64 = 0.02;

impl Run {
    /// What is wrong with the labels of the points that trained a model, whose modes are `predicted`: a
    /// mode that is followed from one point to the nearest other one, as a prediction follows it, arrives
    /// at another label.
    pub(in crate::run) fn relabelled(&self, found: &Chosen, predicted: &[[f64; 2]]) -> Option<String> {
        let observed = &found.observed;
        let labels: BTreeSet<&str> = observed.iter().map(|o| o.mode.label.as_str()).collect();
        if labels.len() < 2 {
            return None;
        }
        let points: Vec<String> = observed.iter().map(|o| o.conditions.id.clone()).collect();
        let followed = Followed::of(&self.study, observed, &points);
        let values = found.trained.best();
        let s = |k: usize| C64::new(predicted[k][0], predicted[k][1]);
        let jump = |k: usize| {
            let o = &observed[k];
            let (from, arrived) = followed.arrives(&found.assembly, values, &o.mode.label, &o.conditions)?;
            let here = (0..observed.len()).filter(|j| observed[*j].conditions.id == o.conditions.id);
            let nearest =
                here.min_by(|a, b| (s(*a) - arrived).norm().total_cmp(&(s(*b) - arrived).norm()))?;
            let there = nearest != k && (s(nearest) - arrived).norm() < SAME * arrived.norm();
            there.then_some((from, o, observed[nearest].mode.label.as_str()))
        };
        let mut jumps = (0..observed.len()).filter_map(jump);
        let (from, o, other) = jumps.next()?;
        let (label, point, more) = (&o.mode.label, &o.conditions.id, jumps.count());
        let more = if more > 0 { format!(", and {more} more like this") } else { String::new() };
        Some(format!(
            "labels of modes are inconsistent: mode `{label}` of point {from}, followed to {point}, is the one labelled `{other}` there{more}; give each mode one \
             label at all points, because predictions follow the mode"
        ))
    }
}
