//! What each candidate of a stage's model does to the modes: the model less the same model without it.

use super::super::combined::assembly_of;
use super::super::course::Run;
use super::super::frame::{Frame, FrameColumn, FrameRow, finite};
use super::super::points::inputs::selected;
use super::answer::Found;
use super::axes::{ANGULAR_FREQUENCY, GROWTH_RATE, apart, axis_label, growth_and_frequency};
use super::kinds::Ask;
use crate::{Assembly, EngineError, Observed, PointModel};
use rayon::prelude::*;
use rijke_network::Workspace;
use rijke_numerics::{C64, Order};
use rijke_study::plan::{Question, Selection};
use rijke_study::{Study, StudyProblem};
use serde::Deserialize;

/// Asks what candidates do to the growth rate and the frequency of the measured modes.
#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct Effects {
    /// The roles whose candidates are taken away, one at a time; all that the model can lose if empty.
    of: Vec<String>,
    /// The points, as far as they were measured.
    points: Selection,
}

/// A mode that moves by more than this part of the distance of modes is not followed: it may be another.
const FAR: f64 = 0.3;

impl Ask for Effects {
    const KIND: &'static str = "effects";

    fn check(&self, study: &Study) -> Result<(), StudyProblem> {
        self.points.check(&study.campaign)?;
        self.of.iter().try_for_each(|role| study.catalogue.known_role(role))
    }

    fn answer(&self, run: &Run, question: &Question) -> Result<Found, EngineError> {
        let no_point = || EngineError::NothingToAnswer { question: question.id.clone() };
        let (_, stage) = run.study.plan.stage(&question.stage).ok_or_else(no_point)?;
        let chosen = run.chosen(&question.stage).ok_or_else(no_point)?;
        let points = selected(&run.study, &run.observed, &self.points);
        if points.is_empty() {
            return Err(no_point());
        }
        let model = chosen.choice();
        let asked = |role: &&String| self.of.is_empty() || self.of.contains(role);
        let (mut rows, mut lost): (Vec<FrameRow>, Vec<&str>) = (Vec::new(), Vec::new());
        for role in model.keys().filter(asked) {
            let mut rest = model.clone();
            let id = rest.remove(role).unwrap_or_default();
            // What the stage holds, but for the parameters of the one that is taken away.
            let gone = run.study.catalogue.get(&id).map_or(&[][..], |c| &c.parameters);
            let mut hold = stage.hold.clone();
            hold.retain(|name, _| gone.iter().all(|p| p.name != *name));
            let without = assembly_of(&run.study, &rest, &hold)?;
            let found: Vec<_> =
                points.par_iter().map(|o| effect(&chosen.assembly, &without, &chosen.trained, o)).collect();
            if found.iter().all(Option::is_none) {
                lost.push(role);
                continue;
            }
            for (o, numbers) in points.iter().zip(found) {
                let point = &o.conditions.point;
                let numbers = numbers.unwrap_or([f64::NAN; 4]);
                rows.push(FrameRow {
                    label: point.id.clone(),
                    series: id.clone(),
                    mode: o.mode.label.clone(),
                    values: point.factors.iter().copied().chain(numbers).map(finite).collect(),
                });
            }
        }
        let mut columns = run.factor_columns();
        let first = columns.len();
        for [name, label, unit] in [GROWTH_RATE, ANGULAR_FREQUENCY] {
            let label = format!("{label}, effect");
            columns.push(FrameColumn::new(&format!("{name}_effect"), &label, unit));
            columns.push(FrameColumn::new(&format!("{name}_effect_sd"), &format!("{label}, sd"), unit));
        }
        let axis = run.axis(question, points.iter().map(|o| &o.conditions.point));
        let panels = axis.map_or_else(Vec::new, |k| {
            let met = points.iter().map(|o| (o.mode.label.as_str(), o.conditions.point.factors[k]));
            growth_and_frequency(&axis_label(&columns[k]), k, first, &[], &apart(met))
        });
        let mut caption = format!(
            "Modes of the model {} less those of the same model without one candidate, with two standard deviations by its parameters. \
             Effects of several candidates do not add up exactly.",
            chosen.assembly.ids().join(", ")
        );
        if !lost.is_empty() {
            caption +=
                &format!(" Without {} the model has no mode near the measured ones.", lost.join(" or "));
        }
        for role in self.of.iter().filter(|role| !model.contains_key(*role)) {
            caption += &format!(" The model has no candidate of the role {role}.");
        }
        Ok((vec![Frame { columns, rows }], panels, Vec::new(), caption))
    }
}

/// Growth rate and angular frequency of a model at a point less those of another, each with its standard
/// deviation to first order; none where the other has no mode nearby.
fn effect(with: &Assembly, without: &Assembly, trained: &crate::Trained, o: &Observed) -> Option<[f64; 4]> {
    let mut conditions = (*o.conditions).clone();
    conditions.base = trained.posterior().as_inferred(&conditions.base);
    let names = |of: &Assembly| of.parameters().iter().map(|p| p.name.clone()).collect::<Vec<_>>();
    let (all, rest) = (names(with), names(without));
    let place = |name: &String| all.iter().position(|n| n == name);
    let places = rest.iter().map(place).collect::<Option<Vec<usize>>>()?;
    let values: Vec<f64> = places.iter().map(|&k| trained.values[k]).collect();
    let at = |assembly: &Assembly, values: &[f64], near: C64| {
        let model = PointModel::new(assembly, &conditions, &[]).ok()?.starting_from(near);
        let s = model.respond(values, Order::First, &mut Workspace::default()).ok()?.s;
        Some((s.value(), s.gradient().to_vec(), model.spacing()))
    };
    let (s, mut gradient, spacing) = at(with, trained.best(), o.near)?;
    let (other, less, _) = at(without, &values, s)?;
    let moved = s - other;
    if moved.norm() > FAR * spacing {
        return None;
    }
    places.iter().zip(less).for_each(|(&k, d)| gradient[k] -= d);
    let sd = |part: fn(&C64) -> f64| {
        let slope: Vec<f64> = gradient.iter().map(part).collect();
        let terms = (0..slope.len()).flat_map(|i| (0..slope.len()).map(move |j| (i, j)));
        let variance: f64 = terms.map(|(i, j)| slope[i] * trained.covariance[(i, j)] * slope[j]).sum();
        variance.max(0.0).sqrt()
    };
    Some([moved.re, sd(|z| z.re), moved.im, sd(|z| z.im)])
}
