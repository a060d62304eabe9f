//! The chosen model of a stage as data that a page solves by itself while a reader moves its parameters and
//! factors.
//!
//! Knows nothing of pages: what is written here is formulas in words, states of the gas at the nodes of a
//! grid, the posterior, and numbers of this engine against which a solver elsewhere is held.

mod script;
mod table;

pub use table::SliderAxis;

use super::answers::factor_column;
use super::combined::assembly_of;
use super::frame::FrameColumn;
use super::points::inputs::{ambient_of_all, selected, states};
use super::points::meant::observed;
use super::record::StageRecord;
use crate::{Assembly, Conditions, EngineError, Misfit, Observed, PointModel, SavedModel};
use rayon::prelude::*;
use rijke_network::Workspace;
use rijke_numerics::words::to_digits;
use rijke_numerics::{C64, InOrder, Order};
use rijke_study::{ObservedModes, Study};
use script::{Script, ka};
use serde::Serialize;
use table::Table;

/// Settings at which a solver elsewhere is held against this engine.
const CHECKS: usize = 1000;

/// Part of |s| by which a parameter alone moves a mode at the end of its range.
const REACH: f64 = 0.04;

/// What a page needs of a model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sliders {
    /// Name of the stage.
    pub stage: String,
    /// What it is called.
    pub title: String,
    /// What the model is called.
    pub model: String,
    /// Why it stands in the place of the model that went on, if it does.
    #[serde(skip)]
    pub instead: Option<String>,
    /// Every factor of the campaign, as the column of a table.
    pub factors: Vec<FrameColumn>,
    /// The parameters.
    pub parameters: Vec<SliderParameter>,
    /// Their covariance in a new installation of the rig.
    pub covariance: Vec<Vec<f64>>,
    /// Labels of the modes.
    pub modes: Vec<String>,
    /// Every operating point with its modes, in the order of the table.
    pub nodes: Vec<SliderNode>,
    /// How far the tabulated states move growth rates (1/s) and angular frequencies (rad/s) from those of the
    /// states themselves, at most.
    pub tabulated: [f64; 2],
    /// Misfit of the growth rate that counts for stability, 1/s.
    pub misfit: f64,
    table: Table,
    script: Script,
    /// Settings: number of the mode, axes, parameters, and s of this engine there. No part of what a page
    /// needs.
    #[serde(skip)]
    pub checks: Vec<Vec<f64>>,
}

/// A parameter and its range.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SliderParameter {
    /// Name.
    pub name: String,
    /// Symbol in print.
    pub symbol: String,
    /// Unit.
    pub unit: String,
    /// Most probable value.
    pub value: f64,
    /// Standard deviation.
    pub sd: f64,
    /// Least and largest value that can be set.
    pub range: [f64; 2],
}

/// An operating point.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SliderNode {
    /// Its name.
    pub point: String,
    /// Its modes, in the order of the labels; none for one that was not measured there.
    pub modes: Vec<Option<SliderMode>>,
}

/// A mode at an operating point.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SliderMode {
    /// Growth rate as measured, 1/s, and its standard deviation.
    pub growth_rate: Option<[f64; 2]>,
    /// Angular frequency as measured, rad/s, and its standard deviation.
    pub angular_frequency: Option<[f64; 2]>,
    /// s of the most probable parameters in the tabulated state.
    pub s: [f64; 2],
    /// What the training found of errors that all points share adds to s.
    pub shift: [f64; 2],
    /// Standard deviation of the growth rate by everything but the parameters, 1/s.
    pub other_sd: f64,
}

/// A node before its table is written.
struct Solved {
    mode: SliderMode,
    /// s in the state itself.
    there: C64,
    /// |ds/dp|, relative to |s|.
    slopes: Vec<f64>,
}

/// The model that went on from the last stage at which models competed, or from the last.
///
/// # Errors
/// A sentence that says why a page cannot solve it.
pub fn sliders(
    study: &Study,
    observations: &ObservedModes,
    record: &StageRecord,
    saved: &SavedModel,
) -> Result<Sliders, String> {
    let said = |error: EngineError| error.to_string();
    let assembly = assembly_of(study, &saved.candidates, &saved.hold).map_err(said)?;
    if study.rig.is_of_unknown_shape() {
        return Err("lengths, temperatures or places of its rig are unknown".to_owned());
    }
    if assembly.candidates().iter().flat_map(|c| &c.effects).any(|e| e.hears.is_some()) {
        return Err("a flame answers to the velocity elsewhere".to_owned());
    }
    if study.rig.parts.iter().any(rijke_study::Part::is_of_other_gas) {
        return Err("a duct has gas of its own".to_owned());
    }
    let ambient = ambient_of_all(study, observations);
    let states = states(study, &ambient, true).map_err(said)?;
    let all = observed(study, observations, &states, &ambient).map_err(said)?;
    let stage = study.plan.stage(&record.id).map(|(_, stage)| stage);
    let used = stage.map_or_else(Vec::new, |stage| selected(study, &all, &stage.points));
    if assembly.mean_flow().is_some() && used.iter().any(|o| o.conditions.base.mass_flow > 0.0) {
        return Err("its waves are those of a mean flow".to_owned());
    }
    let mut points: Vec<&Observed> = Vec::new();
    for o in &used {
        if points.iter().all(|p| p.conditions.id != o.conditions.id) {
            points.push(o);
        }
    }
    if points.is_empty() {
        return Err("no mode was measured at its points".to_owned());
    }
    let (table, order) = Table::of(&points)?;
    let mut modes: Vec<String> = Vec::new();
    used.iter().for_each(|o| {
        if !modes.contains(&o.mode.label) {
            modes.push(o.mode.label.clone());
        }
    });
    let model = Model::of(&assembly, saved).map_err(said)?;
    let node = |(node, &place): (usize, &usize)| -> Result<Vec<Option<Solved>>, EngineError> {
        let id = &points[place].conditions.id;
        let of = |label: &String| used.iter().find(|o| o.conditions.id == *id && o.mode.label == *label);
        let setting = table.setting(node);
        modes.iter().map(|label| of(label).map(|o| model.solved(o, &table, &setting)).transpose()).collect()
    };
    let solved: Vec<Vec<Option<Solved>>> = order
        .par_iter()
        .enumerate()
        .map(|(k, place)| node((k, place)))
        .in_order::<Result<_, _>>()
        .map_err(said)?;
    let every = || solved.iter().flatten().flatten();
    let apart = |part: fn(C64) -> f64| {
        every().map(|m| part(m.there - C64::new(m.mode.s[0], m.mode.s[1])).abs()).fold(0.0, f64::max)
    };
    let tabulated = [apart(|z| z.re), apart(|z| z.im)];
    let parameters = model.parameters(&every().map(|m| &m.slopes[..]).collect::<Vec<_>>());
    let range = order.iter().zip(&solved).flat_map(|(&place, modes)| {
        let conditions = &points[place].conditions;
        modes.iter().flatten().map(move |m| ka(conditions, m.there.im))
    });
    let range = range.fold([f64::INFINITY, 0.0], |[a, b], [low, high]| [a.min(low), f64::max(b, high)]);
    let first = &points[0].conditions;
    let at_first = PointModel::new(&assembly, first, &[]).map_err(said)?;
    let script = Script::of(&assembly, &at_first, range)?;
    let nodes = order.iter().zip(solved).map(|(&place, modes)| SliderNode {
        point: points[place].conditions.id.clone(),
        modes: modes.into_iter().map(|m| m.map(|m| m.mode)).collect(),
    });
    let nodes: Vec<SliderNode> = nodes.collect();
    let checks = model.checks(&table, first, &nodes, &parameters);
    if checks.is_empty() {
        return Err(
            "no mode was measured at neighbouring values of its factors, between which it could be followed"
                .to_owned(),
        );
    }
    let label = record.models.iter().find(|m| m.candidates == saved.candidates).map(|m| m.label.clone());
    Ok(Sliders {
        stage: record.id.clone(),
        title: record.title.clone(),
        model: label.unwrap_or_default(),
        instead: None,
        factors: study.campaign.factors.iter().map(factor_column).collect(),
        parameters,
        covariance: model.covariance,
        modes,
        nodes,
        tabulated,
        misfit: short(Misfit::of_growth(&model.posterior.noise)),
        table,
        script,
        checks,
    })
}

impl Sliders {
    /// The factors that vary independently of each other.
    #[must_use]
    pub fn axes(&self) -> &[SliderAxis] {
        &self.table.axes
    }
}

/// A trained model.
struct Model<'a> {
    assembly: &'a Assembly,
    saved: &'a SavedModel,
    posterior: crate::TrainedPosterior,
    /// Most probable values of the free parameters, and their covariance in a new installation.
    values: Vec<f64>,
    covariance: Vec<Vec<f64>>,
}

impl<'a> Model<'a> {
    fn of(assembly: &'a Assembly, saved: &'a SavedModel) -> Result<Self, EngineError> {
        let posterior = saved.posterior()?;
        let known = posterior.gaussian.in_a_new_installation(&posterior.noise);
        let place = |name: &str| {
            let unknown =
                || EngineError::UnknownParameter { name: name.to_owned(), known: known.names.join(", ") };
            known.names.iter().position(|n| n == name).ok_or_else(unknown)
        };
        let places: Vec<usize> =
            assembly.parameters().iter().map(|p| place(&p.name)).collect::<Result<_, _>>()?;
        let values = places.iter().map(|&k| known.mean[k]).collect();
        let covariance =
            places.iter().map(|&i| places.iter().map(|&j| known.covariance[(i, j)]).collect()).collect();
        Ok(Self { assembly, saved, posterior, values, covariance })
    }

    /// s and its derivatives in the parameters.
    fn respond(
        &self,
        conditions: &Conditions,
        near: C64,
        values: &[f64],
    ) -> Result<(C64, Vec<C64>), EngineError> {
        let model = PointModel::new(self.assembly, conditions, &[])?.starting_from(near);
        let found = model.respond(values, Order::First, &mut Workspace::default())?;
        let count = values.len();
        Ok((found.s.value(), (0..count).map(|k| found.s.gradient()[k]).collect()))
    }

    /// A measured mode.
    fn solved(&self, o: &Observed, table: &Table, setting: &[f64]) -> Result<Solved, EngineError> {
        let (there, slopes) = self.respond(&o.conditions, o.near, &self.values)?;
        let tabulated = table.conditions(&self.assembly.rig, &o.conditions, setting)?;
        let (s, _) = self.respond(&tabulated, there, &self.values)?;
        let law = self.saved.law.as_ref();
        let predicted = self.posterior.predict(self.assembly, &o.conditions, &[], Some(there), law)?;
        let own: f64 = (0..slopes.len())
            .flat_map(|i| (0..slopes.len()).map(move |j| (i, j)))
            .map(|(i, j)| slopes[i].re * self.covariance[i][j] * slopes[j].re)
            .sum();
        let total = predicted.sd(0, &Misfit::default()).powi(2);
        let record = super::record::MeasuredRecord::of(o);
        let mode = SliderMode {
            growth_rate: record.growth_rate.map(|v| v.map(short)),
            angular_frequency: record.angular_frequency.map(|v| v.map(short)),
            s: [s.re, s.im],
            shift: [predicted.values[0] - there.re, predicted.values[1] - there.im].map(short),
            other_sd: short((total - own).max(0.0).sqrt()),
        };
        Ok(Solved { mode, there, slopes: slopes.iter().map(|z| z.norm() / there.norm()).collect() })
    }

    /// The parameters with the ranges in which they can be set: as wide as their priors, but none so wide
    /// that a mode gets lost.
    fn parameters(&self, slopes: &[&[f64]]) -> Vec<SliderParameter> {
        let one = |(k, p): (usize, &rijke_inference::Parameter)| {
            let value = self.values[k];
            let sd = p.sd_about(value, self.covariance[k][k].sqrt());
            let steepest = slopes.iter().map(|s| s[k]).fold(0.0, f64::max);
            let wide = 0.5 * (p.prior.quantile(0.98) - p.prior.quantile(0.02));
            let reach = wide.min(REACH / steepest).max(3.0 * sd);
            let range = [
                (value - reach).max(p.prior.quantile(1e-6)).min(value),
                (value + reach).min(p.prior.quantile(1.0 - 1e-6)).max(value),
            ];
            let (name, symbol, unit) = (p.name.clone(), p.symbol.clone(), p.unit.clone());
            SliderParameter { name, symbol, unit, value, sd, range }
        };
        self.assembly.parameters().iter().enumerate().map(one).collect()
    }

    /// Settings all over the ranges, by a sequence of low discrepancy, and s there; settings without a mode
    /// are left out. The more parameters there are, the less each moves.
    fn checks(
        &self,
        table: &Table,
        like: &Conditions,
        nodes: &[SliderNode],
        parameters: &[SliderParameter],
    ) -> Vec<Vec<f64>> {
        let share = (parameters.len().max(1) as f64).sqrt().recip();
        let modes = nodes.first().map_or(0, |n| n.modes.len());
        let one = |k: usize| -> Option<Vec<f64>> {
            let number = |d: usize| sequence(k, d, 1 + table.axes.len() + parameters.len());
            let mode = ((number(0) * modes as f64) as usize).min(modes - 1);
            let along = |(d, axis): (usize, &SliderAxis)| {
                let (low, high) = (axis.levels.first()?, axis.levels.last()?);
                Some(short(low + number(1 + d) * (high - low)).clamp(*low, *high))
            };
            let setting: Vec<f64> = table.axes.iter().enumerate().map(along).collect::<Option<_>>()?;
            let value = |(d, p): (usize, &SliderParameter)| {
                let turn = 2.0 * number(1 + table.axes.len() + d) - 1.0;
                let end = p.range[usize::from(turn > 0.0)];
                short(p.value + share * turn.abs() * (end - p.value))
            };
            let values: Vec<f64> = parameters.iter().enumerate().map(value).collect();
            let part = |i: usize| {
                table.between(&setting, |node| nodes[node].modes[mode].as_ref().map_or(f64::NAN, |m| m.s[i]))
            };
            let near = C64::new(part(0), part(1));
            let conditions = table.conditions(&self.assembly.rig, like, &setting).ok()?;
            let (s, _) = self.respond(&conditions, near, &values).ok()?;
            Some([&[mode as f64], &setting[..], &values[..], &[s.re, s.im]].concat())
        };
        (0..CHECKS).into_par_iter().filter_map(one).collect()
    }
}

/// Six digits are enough of a setting and of a measured number.
fn short(x: f64) -> f64 {
    to_digits(x, 6)
}

/// Number `k` of dimension `d` of `n` of Kronecker's sequence whose ratios are powers of the root of
/// x^(n+1) = x + 1 (M. Roberts, 2018, "The unreasonable effectiveness of quasirandom sequences").
fn sequence(k: usize, d: usize, n: usize) -> f64 {
    let root = (0..64).fold(1.5_f64, |x, _| (1.0 + x).powf(1.0 / (n as f64 + 1.0)));
    (0.5 + (k + 1) as f64 * root.powi(-(d as i32 + 1))).fract()
}
