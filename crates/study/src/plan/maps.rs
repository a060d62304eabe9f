//! Maps of stability that a study asks for: two factors, and the stage whose model foresees.

use super::Plan;
use super::ids::{known_stage, short_id};
use crate::{Campaign, StudyProblem};
use rijke_numerics::range;
use serde::Deserialize;
use std::collections::BTreeMap;

/// Growth rate and probability of instability over two factors.
#[derive(Clone, Debug, PartialEq)]
pub struct MapQuestion {
    /// Name of the map, also of its files.
    pub id: String,
    /// What it is called.
    pub title: String,
    /// The stage whose model foresees.
    pub stage: String,
    /// The grid.
    pub grid: MapGrid,
}

/// A grid of two factors.
#[derive(Clone, Debug, PartialEq)]
pub struct MapGrid {
    /// The horizontal and the vertical factor, by their places in the campaign.
    pub factors: [usize; 2],
    /// Values of each, ascending, SI.
    pub values: [Vec<f64>; 2],
}

/// Values of each factor.
const GRID: usize = 15;

impl MapGrid {
    /// A grid between two values of each factor, SI; between the lowest and the highest of the campaign where
    /// none are given.
    ///
    /// # Errors
    /// [`StudyProblem::Value`] where one factor is named twice, or its ends are no two ascending numbers.
    pub fn new(
        campaign: &Campaign,
        factors: [usize; 2],
        ends: [Option<[f64; 2]>; 2],
    ) -> Result<Self, StudyProblem> {
        let name = |k: usize| campaign.factors[factors[k]].name.clone();
        if factors[0] == factors[1] {
            return Err(StudyProblem::Value {
                key: "the factors of a map".into(),
                value: format!("{0}, {0}", name(0)),
                need: "two factors that differ",
            });
        }
        let axis = |k: usize| {
            let all = campaign.points.iter().map(|p| p.factors[factors[k]]).filter(|v| v.is_finite());
            let [low, high] = ends[k].unwrap_or_else(|| range(all));
            if low.is_finite() && high.is_finite() && low < high {
                return Ok((0..GRID).map(|i| low + (high - low) * i as f64 / (GRID - 1) as f64).collect());
            }
            let need = match ends[k] {
                Some(_) => "a lower and a higher value, in SI units",
                None => "a factor with several values in the campaign, or the ends of its range",
            };
            let value = ends[k].map_or("one value only".into(), |[low, high]| format!("{low} to {high}"));
            Err(StudyProblem::Value { key: name(k), value, need })
        };
        Ok(Self { factors, values: [axis(0)?, axis(1)?] })
    }
}

/// A map as its file has it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MapFile {
    id: String,
    title: Option<String>,
    stage: String,
    over: [String; 2],
    #[serde(default)]
    range: BTreeMap<String, [f64; 2]>,
}

impl MapFile {
    /// The map, every name of it checked.
    pub(super) fn question(self, plan: &Plan, campaign: &Campaign) -> Result<MapQuestion, StudyProblem> {
        short_id(&self.id)?;
        known_stage(plan, "stage", &self.stage)?;
        if plan.answers().any(|id| *id == self.id) {
            return Err(StudyProblem::Duplicate { what: "stage, question or map", name: self.id });
        }
        let [x, y] = &self.over;
        let factors = [campaign.known_factor(x)?, campaign.known_factor(y)?];
        if let Some(other) = self.range.keys().find(|name| *name != x && *name != y) {
            let known = crate::source::listed(self.over.iter().map(String::as_str));
            return Err(StudyProblem::Unknown { what: "factor of the map", name: other.clone(), known });
        }
        let ends = [x, y].map(|name| self.range.get(name).copied());
        let grid = MapGrid::new(campaign, factors, ends)?;
        Ok(MapQuestion {
            title: self.title.unwrap_or_else(|| self.id.clone()),
            id: self.id,
            stage: self.stage,
            grid,
        })
    }
}
