//! A visit of an operating point, at which several modes are measured.

use super::predictive::Numbers;
use rijke_numerics::Matrix;
use std::collections::{BTreeMap, BTreeSet};

/// Difference of eigenvalues, as a part of the frequency, below which they are one.
const SAME: f64 = 1e-6;

/// What a visit reads of each of its modes, with their labels.
#[derive(Clone, Debug, Default)]
pub(super) struct Visit(pub(super) Vec<(String, Numbers)>);

impl Visit {
    /// Adds a mode, unless it is one of those that are there: what was not followed to this point may be
    /// sought where another mode is.
    pub(super) fn add(&mut self, label: String, mode: Numbers) {
        let same = |(_, other): &(String, Numbers)| {
            let [growth, omega] = [0, 1].map(|k| other.values[k] - mode.values[k]);
            growth.hypot(omega) < SAME * mode.values[1].abs()
        };
        if !self.0.iter().any(same) {
            self.0.push((label, mode));
        }
    }

    /// Keeps the modes that all have: by the others models cannot be compared.
    pub(super) fn keep_common<'a>(visits: impl Iterator<Item = &'a mut Self>) {
        let visits: Vec<&mut Self> = visits.collect();
        let labels = |v: &Self| v.0.iter().map(|(label, _)| label.clone()).collect::<BTreeSet<_>>();
        let common = visits.iter().map(|v| labels(v)).reduce(|all, v| &all & &v).unwrap_or_default();
        visits.into_iter().for_each(|v| v.0.retain(|(label, _)| common.contains(label)));
    }

    /// The largest growth rate of a mode, 1/s.
    pub(super) fn fastest(&self) -> f64 {
        self.0.iter().map(|(_, mode)| mode.values[0]).fold(f64::NEG_INFINITY, f64::max)
    }

    /// What is measured in all, if `seen` says what is measured of each mode.
    pub(super) fn seen(&self, seen: &dyn Fn(&Numbers) -> Numbers) -> Numbers {
        Numbers::together(self.0.iter().map(|(_, mode)| seen(mode)).collect())
    }
}

impl Numbers {
    /// Several modes of one visit, whose noises are independent.
    fn together(modes: Vec<Self>) -> Self {
        let rows: usize = modes.iter().map(|m| m.values.len()).sum();
        let mut all =
            Self { noise: Matrix::zeros(rows, rows), stays: Matrix::zeros(rows, rows), ..Self::default() };
        let mut along: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
        for mode in modes {
            let (start, n) = (all.values.len(), mode.values.len());
            let add = |to: &mut Vec<f64>, slope: &[f64]| {
                to.resize(rows, 0.0);
                to[start..start + n].iter_mut().zip(slope).for_each(|(t, d)| *t += d);
            };
            mode.along.iter().for_each(|(place, slope)| add(along.entry(*place).or_default(), slope));
            for (cause, slope) in mode.shared {
                add(all.shared.entry(cause).or_default(), &slope);
            }
            for i in 0..n {
                for j in 0..n {
                    all.noise[(start + i, start + j)] = mode.noise[(i, j)];
                    all.stays[(start + i, start + j)] = mode.stays[(i, j)];
                }
            }
            all.values.extend(mode.values);
        }
        Self { along: along.into_iter().collect(), ..all }
    }
}
