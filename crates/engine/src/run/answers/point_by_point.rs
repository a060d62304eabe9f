//! A coefficient inferred at every point by itself (Figs. 6 and 7 of Juniper & Yoko 2022).

use super::super::combined::assembly_of;
use super::super::course::Run;
use super::super::frame::{Frame, FrameColumn};
use super::super::points::inputs::selected;
use super::answer::{AnswerPanel, Found, Layer, LayerLook};
use super::axes::{axis_label, symbol};
use super::kinds::Ask;
use super::law::LawValue;
use crate::rows::with_candidates;
use crate::{EngineError, Noise, Observed, PointModel, train};
use rayon::prelude::*;
use rijke_network::Workspace;
use rijke_numerics::{InOrder, Order};
use rijke_study::plan::{NoiseSpec, Question, Selection};
use rijke_study::{Candidate, Study, StudyProblem};
use serde::Deserialize;
use std::collections::BTreeMap;

/// Asks for a coefficient that is free at every point.
#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct PointByPoint {
    /// Role and candidate; the coefficient is the first law of the one whose role the stage's model does not
    /// have.
    with: BTreeMap<String, String>,
    /// Roles of the stage's model that are taken away.
    without: Vec<String>,
    /// Parameters held at a value.
    hold: BTreeMap<String, f64>,
    /// The points.
    points: Selection,
    /// What is assumed of the misfit.
    noise: NoiseSpec,
    /// Whether the errors of the base states enter.
    base_errors: bool,
    /// The factor by which the coefficient is divided for show.
    per: Option<String>,
}

impl Ask for PointByPoint {
    const KIND: &'static str = "point-by-point";

    fn check(&self, study: &Study) -> Result<(), StudyProblem> {
        self.points.check(&study.campaign)?;
        if self.with.is_empty() {
            let need = "name the role and the candidate that is free at every point";
            return Err(StudyProblem::Missing { key: "with".into(), need });
        }
        self.per.iter().try_for_each(|name| study.campaign.known_factor(name).map(|_| ()))?;
        self.noise.check(&study.plan, &study.campaign, &study.catalogue)
    }

    fn answer(&self, run: &Run, question: &Question) -> Result<Found, EngineError> {
        run.point_by_point(question, self)
    }
}

impl Run {
    /// Every point is an inference of its own: the parameters of the candidate are free, and the parameters
    /// of all others have the posterior of the stage as their prior, so that their uncertainty is part of the
    /// standard deviation.
    fn point_by_point(&self, question: &Question, one: &PointByPoint) -> Result<Found, EngineError> {
        let no_stage = || EngineError::NoPoint { stage: question.stage.clone() };
        let (_, stage) = self.study.plan.stage(&question.stage).ok_or_else(no_stage)?;
        let done = self.stage_done(&question.stage).ok_or_else(no_stage)?;
        let mut choice = done.choice.clone();
        choice.retain(|role, _| !one.without.contains(role));
        let own: Vec<Candidate> =
            one.with.values().filter_map(|id| self.study.catalogue.get(id).cloned()).collect();
        let choice = with_candidates(choice, &own);
        let assembly = assembly_of(&self.study, &choice, &one.hold)?;
        let known = done.chosen.trained.gaussian();
        let points: Vec<Observed> = selected(&self.study, &self.observed, &one.points)
            .iter()
            .map(|o| known.without_channels(&self.rig, o))
            .collect();
        if points.is_empty() {
            return Err(EngineError::NothingToAnswer { question: question.id.clone() });
        }
        let noise = Noise { law: self.law_of(stage, &one.noise, &done.choice)?, ..self.noise(&one.noise)? };
        let mut training = self.training(stage, noise, vec![known], super::super::Trusted::Laplace);
        (training.base_errors, training.channels) = (one.base_errors, None);
        // Nothing stands on one point: its errors are covariance.
        (training.assemblies, training.causes) = (Vec::new(), Vec::new());
        // The one that brings a role of its own; the others take the places of those that the stage has.
        let free = own.iter().find(|c| !done.choice.contains_key(&c.role)).or(own.first());
        let place = assembly.candidates().iter().position(|c| free.is_some_and(|o| o.id == c.id));
        let per = one.per.as_ref().and_then(|name| self.study.campaign.factor(name));
        let at = |o: &Observed| {
            let trained = train(&assembly, std::slice::from_ref(o), &training)?;
            let model = PointModel::new(&assembly, &o.conditions, &[])?.starting_from(o.near);
            let values = trained.best();
            let s = model.respond(values, Order::Value, &mut Workspace::default())?.s.value();
            let per = per.map_or(1.0, |k| o.conditions.point.factors[k]);
            let law = LawValue::of(&model, [place.unwrap_or(0), 0], s, &trained);
            Ok(law.map_or([f64::NAN; 6], |law| law.over(per).numbers()))
        };
        let found = points.par_iter().map(at).in_order::<Result<Vec<_>, EngineError>>()?;
        let (name, unit) = self.coefficient(free, per);
        let mut columns = self.factor_columns();
        let first = columns.len();
        for (column, label, unit) in [
            ("real", format!("Re {name}"), &unit),
            ("imaginary", format!("Im {name}"), &unit),
            ("modulus", format!("|{name}|"), &unit),
            ("modulus_sd", format!("|{name}|, sd"), &unit),
            ("angle", format!("Angle of {name}"), &"rad".to_owned()),
            ("angle_sd", format!("Angle of {name}, sd"), &"rad".to_owned()),
        ] {
            columns.push(FrameColumn::new(column, &label, unit));
        }
        let rows = points.iter().zip(&found);
        let rows = rows.map(|(o, n)| self.row_of(question, &o.conditions.point, &o.mode.label, n)).collect();
        let axis = self.axis(question, points.iter().map(|o| &o.conditions.point));
        let panel = |axis: usize, y: usize| AnswerPanel {
            x: axis_label(&columns[axis]),
            y: axis_label(&columns[y]),
            layers: vec![Layer { frame: 0, look: LayerLook::Dots, x: axis, y, sd: Some(y + 1), mode: None }],
        };
        let panels = axis.map_or_else(Vec::new, |k| vec![panel(k, first + 2), panel(k, first + 4)]);
        let caption =
            format!("{name}, inferred at each point by itself, in the model {}.", assembly.ids().join(", "));
        Ok((vec![Frame { columns, rows }], panels, Vec::new(), caption))
    }

    /// The name and the unit of the coefficient of a candidate.
    fn coefficient(&self, candidate: Option<&Candidate>, per: Option<usize>) -> (String, String) {
        let Some(effect) = candidate.and_then(|c| c.effects.first()) else { return Default::default() };
        let (name, unit) = (effect.coefficient.name(), effect.coefficient.unit(effect.place.is_along()));
        match per.map(|k| &self.study.campaign.factors[k]) {
            Some(factor) => (
                format!("k_{{{name}}}/{}", symbol(&factor.name)),
                format!("{unit} per {}", factor.unit_in_print()),
            ),
            None => (format!("k_{{{name}}}"), unit.to_owned()),
        }
    }
}
