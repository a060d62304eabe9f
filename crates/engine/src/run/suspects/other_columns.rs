//! Columns of the campaign that were exchanged, or hold twice or half of what is meant, as diameters for
//! radii do: by training again with the numbers put right.

use super::super::course::{Chosen, Run};
use super::super::points::inputs::conditions_or_ambient;
use super::miswired::{LEADS, NEARER};
use crate::noise::measured_sd;
use crate::rows::Row;
use crate::{EngineError, Observed};
use rijke_study::plan::Stage;
use rijke_study::{Campaign, Point};
use std::fmt;
use std::sync::Arc;

/// A misfit of the frequencies, in measured standard deviations and as a part of them, that asks for the
/// question.
const LARGE: f64 = 3.0;
const PART: f64 = 5e-3;

/// Most columns that are asked about: every pair of one unit is trained once.
const COLUMNS: usize = 5;

impl Run {
    /// What a model that misses the frequencies by far gains most with columns of the campaign put right, in
    /// a sentence; nothing of what gains less than [`LEADS`]. Where the state of the gas was inferred, which
    /// rests on the same columns, nothing is asked.
    ///
    /// # Errors
    /// [`EngineError::Stopped`].
    pub(in crate::run) fn other_columns(
        &self,
        stage: &Stage,
        row: &Row,
        found: &Chosen,
    ) -> Result<Option<String>, EngineError> {
        let omega: Vec<f64> = found.observed.iter().filter_map(|o| o.mode.angular_frequency).collect();
        let mean = omega.iter().sum::<f64>() / omega.len().max(1) as f64;
        let large = (LARGE * measured_sd(&found.observed, 1)).max(PART * mean);
        if omega.len() < 3 || found.misfit[1].is_nan() || found.misfit[1] < large || !self.states.is_empty() {
            return Ok(None);
        }
        let mut best: Option<(Slip, f64)> = None;
        for slip in self.slips(found) {
            // Numbers that no rig can have are no slip of this kind.
            let Ok(points) = self.with_columns(found, slip) else { continue };
            let Some(other) = self.with_data(stage, row, found, points)? else { continue };
            let nearer = other.misfit[1] < NEARER * found.misfit[1];
            if nearer && other.gain > best.map_or(LEADS, |(_, most)| most) {
                best = Some((slip, other.gain));
            }
        }
        Ok(best.map(|(slip, gain)| {
            let said = slip.said(&self.study.campaign);
            format!("this model gains {gain:.1} nats if {said}: check which is right")
        }))
    }

    /// What may be wrong with the columns that differ between the points.
    fn slips(&self, found: &Chosen) -> Vec<Slip> {
        let factors = &self.study.campaign.factors;
        let values = |k: usize| found.observed.iter().map(move |o| o.conditions.point.factors[k]);
        let varies = |k: &usize| {
            let mut all = values(*k).filter(|v| v.is_finite());
            all.next().is_some_and(|first| all.any(|v| v != first))
        };
        let columns: Vec<usize> = (0..factors.len()).filter(varies).take(COLUMNS).collect();
        let pairs =
            columns.iter().flat_map(|a| columns.iter().filter(move |b| *b > a).map(move |b| [*a, *b]));
        let alike = |[a, b]: &[usize; 2]| {
            factors[*a].unit == factors[*b].unit && values(*a).zip(values(*b)).any(|(x, y)| x != y)
        };
        // What is there or absent is no length.
        let measured = |k: &usize| factors[*k].unit != "1";
        let times =
            columns.iter().copied().filter(measured).flat_map(|k| [Slip::Times(k, 2.0), Slip::Times(k, 0.5)]);
        pairs.filter(alike).map(Slip::Exchanged).chain(times).collect()
    }

    /// The observations of a model at points whose columns are put right.
    fn with_columns(&self, found: &Chosen, slip: Slip) -> Result<Vec<Observed>, EngineError> {
        let campaign = &self.study.campaign;
        let one = |o: &Observed| {
            let mut point = o.conditions.point.clone();
            slip.put_right(&mut point);
            let ambient = campaign.point(&point.id).and_then(|(k, _)| self.ambient.get(k).copied().flatten());
            let conditions = Arc::new(conditions_or_ambient(&self.study, &point, None, ambient)?);
            Ok(Observed { conditions, ..o.clone() })
        };
        found.observed.iter().map(one).collect()
    }
}

/// What may be wrong with columns, by their places among the factors.
#[derive(Clone, Copy)]
enum Slip {
    Exchanged([usize; 2]),
    Times(usize, f64),
}

impl Slip {
    /// Puts the numbers of a point right.
    fn put_right(self, point: &mut Point) {
        match self {
            Self::Exchanged([a, b]) => {
                point.factors.swap(a, b);
                point.factor_sds.swap(a, b);
            }
            Self::Times(k, by) => {
                point.factors[k] *= by;
                point.factor_sds[k] *= by;
            }
        }
    }

    fn said(self, campaign: &Campaign) -> impl fmt::Display {
        let name = |k: usize| &campaign.factors[k].name;
        match self {
            Self::Exchanged([a, b]) => {
                format!("the columns `{}` and `{}` of the campaign are exchanged", name(a), name(b))
            }
            Self::Times(k, by) => {
                format!("all numbers of the column `{}` of the campaign are multiplied by {by}", name(k))
            }
        }
    }
}
