//! The models of a stage against what was measured, over a factor (Fig. 4 of Juniper & Yoko 2022).

use super::super::course::{Chosen, Run};
use super::super::frame::{Frame, FrameColumn, FrameRow, finite};
use super::super::points::inputs::conditions_or_ambient;
use super::super::record::ModelRecord;
use super::answer::{Found, LayerLook};
use super::axes::{
    apart, axis_label, factor_column, growth_and_frequency, measured, measured_columns, missed,
    missed_columns,
};
use super::kinds::Ask;
use crate::{Conditions, EngineError, Observed, PointModel};
use rijke_network::Workspace;
use rijke_numerics::{C64, Order};
use rijke_study::plan::{Base, Question};
use serde::Deserialize;

/// How many models a figure shows as lines, and as dashes at every point: those with the most evidence.
const MOST_LINES: usize = 7;
const MOST_DASHES: usize = 2;

/// Number of places at which lines are computed.
const LINE_POINTS: usize = 121;

/// Asks for curves of a stage's competitors over a factor.
#[derive(Deserialize)]
pub(super) struct Ranking {}

impl Ask for Ranking {
    const KIND: &'static str = "ranking";

    fn answer(&self, run: &Run, question: &Question) -> Result<Found, EngineError> {
        run.ranking(question)
    }
}

impl Run {
    fn ranking(&self, question: &Question) -> Result<Found, EngineError> {
        let Some(done) = self.stage_done(&question.stage) else {
            return Err(EngineError::NoPoint { stage: question.stage.clone() });
        };
        let points = done.chosen.observed.clone();
        let mut models: Vec<&(ModelRecord, Chosen)> = done.rows.iter().collect();
        models.sort_by(|a, b| b.0.ln_evidence().total_cmp(&a.0.ln_evidence()));
        let row = |o: &Observed| self.row_of(question, &o.conditions.point, &o.mode.label, &measured(o));
        let columns = [self.factor_columns(), measured_columns()].concat();
        let mut frames = vec![Frame { columns, rows: points.iter().map(row).collect() }];
        let Some(axis) = self.axis(question, points.iter().map(|o| &o.conditions.point)) else {
            return Ok((frames, Vec::new(), Vec::new(), String::new()));
        };
        let x = factor_column(&self.study.campaign.factors[axis]);
        // What points share was estimated where they are.
        let shared = models.iter().any(|(record, _)| !record.fitted.is_empty());
        let line = if shared { Vec::new() } else { self.line(axis, &points)? };
        if line.is_empty() {
            // The one that went on is drawn, whatever its evidence.
            models.sort_by_key(|(record, _)| record.candidates != done.choice);
        }
        models.truncate(if line.is_empty() { MOST_DASHES } else { MOST_LINES });
        let mut rows = Vec::new();
        for (record, chosen) in &models {
            let values = chosen.trained.best();
            let mut work = Workspace::default();
            let mut at = |conditions: &Conditions, near: C64| {
                let heard = self.reference();
                let model =
                    PointModel::new(&chosen.assembly, conditions, heard.as_slice())?.starting_from(near);
                let s = model.respond(values, Order::Value, &mut work)?.s.value();
                let values = [conditions.point.factors[axis], s.re, s.im].map(finite).to_vec();
                Ok::<_, EngineError>(FrameRow {
                    label: conditions.id.clone(),
                    series: record.label.clone(),
                    values,
                    ..FrameRow::default()
                })
            };
            for (conditions, near) in &line {
                rows.push(at(conditions, *near)?);
            }
            if line.is_empty() {
                for (o, s) in points.iter().zip(record.shown()) {
                    let values = [o.conditions.point.factors[axis], s[0], s[1]].map(finite).to_vec();
                    let (label, series) = (o.conditions.id.clone(), record.label.clone());
                    rows.push(FrameRow { label, series, mode: o.mode.label.clone(), values });
                }
            }
        }
        let look = if line.is_empty() { LayerLook::Dashes } else { LayerLook::Line };
        let columns = vec![
            x.clone(),
            FrameColumn::new("growth_rate", "Growth rate", "1/s"),
            FrameColumn::new("angular_frequency", "Angular frequency", "rad/s"),
        ];
        frames.push(Frame { columns, rows });
        let first = self.study.campaign.factors.len();
        let modes = apart(points.iter().map(|o| (o.mode.label.as_str(), o.conditions.point.factors[axis])));
        let below = [(1, look, [1, 2], [None; 2])];
        let mut panels = growth_and_frequency(&axis_label(&x), axis, first, &below, &modes);
        for layer in panels.iter_mut().flat_map(|p| &mut p.layers).filter(|l| l.frame == 1) {
            layer.x = 0;
        }
        // The page begins with the last stage in which models compete.
        let shown = self.done.iter().rev().find(|d| d.rows.len() > 1).or(self.done.last());
        let misses = line.is_empty() && shown.is_some_and(|shown| std::ptr::eq(shown, done));
        if misses {
            let record = models.first().map(|(record, _)| record);
            let rows = points.iter().zip(record.map_or(&[][..], ModelRecord::shown)).map(|(o, s)| {
                let [growth, growth_sd, omega, omega_sd] = measured(o);
                let off =
                    [o.conditions.point.factors[axis], growth - s[0], growth_sd, omega - s[1], omega_sd];
                FrameRow {
                    label: o.conditions.id.clone(),
                    mode: o.mode.label.clone(),
                    values: off.map(finite).to_vec(),
                    ..FrameRow::default()
                }
            });
            let rows = rows.collect();
            frames
                .push(Frame { columns: std::iter::once(x.clone()).chain(missed_columns()).collect(), rows });
            panels.extend(missed(&axis_label(&x), 2, &modes));
        }
        let with = if shared { ", with the errors that points share as estimated" } else { "" };
        let mut caption = if line.is_empty() {
            format!(
                "Measured modes (dots), the model that went on and the next by evidence (short lines){with}."
            )
        } else {
            "Measured modes (dots) and the models with the most evidence.".to_owned()
        };
        if misses {
            caption += " Below, what was measured less the model that went on.";
        }
        Ok((frames, panels, Vec::new(), caption))
    }

    /// Operating points between those of a figure, where the gas is at rest in one temperature; none where it
    /// is not.
    fn line(&self, axis: usize, points: &[Observed]) -> Result<Vec<(Conditions, C64)>, EngineError> {
        let x = |o: &Observed| o.conditions.point.factors[axis];
        let mut ordered: Vec<&Observed> = points.iter().filter(|o| x(o).is_finite()).collect();
        ordered.sort_by(|a, b| x(a).total_cmp(&x(b)));
        // Several points of one place are of several series or modes, between which there is no line.
        let one_each = ordered.windows(2).all(|w| x(w[1]) > x(w[0]));
        let others = |a: &Observed, b: &Observed| {
            let both = a.conditions.point.factors.iter().zip(&b.conditions.point.factors).enumerate();
            both.filter(|(k, _)| *k != axis).all(|(_, (a, b))| a.to_bits() == b.to_bits() || a == b)
        };
        let alike = ordered.windows(2).all(|w| others(w[0], w[1]));
        let at_rest = |o: &&Observed| o.conditions.base.is_uniform() && o.conditions.base.mass_flow == 0.0;
        // Of the gas between points nothing is known where readings tell it.
        let told = matches!(self.study.plan.base, Base::Ambient | Base::Rig | Base::States(_));
        if !told || ordered.len() < 3 || !one_each || !alike || !ordered.iter().all(at_rest) {
            return Ok(Vec::new());
        }
        let (from, to) = (x(ordered[0]), x(ordered[ordered.len() - 1]));
        let at = |k: usize| {
            let here = from + (to - from) * k as f64 / (LINE_POINTS - 1) as f64;
            let after = ordered.iter().position(|o| x(o) >= here).unwrap_or(ordered.len() - 1);
            let (left, right) = (ordered[after.saturating_sub(1)], ordered[after]);
            let share = if x(right) > x(left) { (here - x(left)) / (x(right) - x(left)) } else { 1.0 };
            let [t0, t1] = [left, right].map(|o| o.conditions.base.temperature[0]);
            let mut point = right.conditions.point.clone();
            point.factors[axis] = here;
            Ok((
                conditions_or_ambient(&self.study, &point, None, Some([t0 + (t1 - t0) * share, 0.0]))?,
                right.near,
            ))
        };
        (0..LINE_POINTS).map(at).collect()
    }
}
