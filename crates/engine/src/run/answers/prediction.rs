//! Predictions of the model that a stage chose, trained on its points or on a few (Figs. 5 and 8 to 11 of
//! Juniper & Yoko 2022).

use super::super::course::Run;
use super::super::frame::{Frame, FrameColumn};
use super::super::parameter::parameters;
use super::super::points::followed::Followed;
use super::super::points::inputs::{conditions, selected};
use super::answer::{Found, LayerLook};
use super::axes::{apart, axis_label, growth_and_frequency, measured, measured_columns};
use super::kinds::Ask;
use crate::{Conditions, EngineError, Misfit, Observed, PointPrediction};
use rayon::prelude::*;
use rijke_numerics::{C64, InOrder};
use rijke_study::plan::{Question, Selection};
use rijke_study::{Study, StudyProblem};
use serde::Deserialize;
use std::sync::Arc;

/// Where a mode is predicted, its label, where it is sought, and what was measured of it.
type One<'a> = (Arc<Conditions>, String, Option<C64>, Option<&'a Observed>);

/// Asks for predictions of the model that a stage chose.
#[derive(Default, Deserialize)]
#[serde(default)]
pub(super) struct Prediction {
    /// The points that are predicted.
    points: Selection,
    /// The points that train; those of the stage if absent.
    trained_on: Option<Selection>,
}

impl Prediction {
    /// Of these points.
    pub(super) fn at(points: Selection) -> Self {
        Self { points, trained_on: None }
    }
}

impl Ask for Prediction {
    const KIND: &'static str = "prediction";

    fn check(&self, study: &Study) -> Result<(), StudyProblem> {
        [&self.points].into_iter().chain(&self.trained_on).try_for_each(|of| of.check(&study.campaign))
    }

    fn foresees(&self) -> Option<&Selection> {
        Some(&self.points)
    }

    fn answer(&self, run: &Run, question: &Question) -> Result<Found, EngineError> {
        run.prediction(question, &self.points, self.trained_on.as_ref())
    }
}

/// What is predicted and follows from that: name, label and unit of its columns.
const COLUMNS: [[&str; 3]; 12] = [
    ["predicted_growth_rate", "Growth rate, predicted", "1/s"],
    ["predicted_growth_rate_sd", "Growth rate, sd of a new measurement", "1/s"],
    ["predicted_angular_frequency", "Angular frequency, predicted", "rad/s"],
    ["predicted_angular_frequency_sd", "Angular frequency, sd of a new measurement", "rad/s"],
    ["model_growth_rate_sd", "Growth rate, sd of the model", "1/s"],
    ["model_angular_frequency_sd", "Angular frequency, sd of the model", "rad/s"],
    ["growth_rate_residual", "Growth rate, measured minus predicted", "1/s"],
    ["angular_frequency_residual", "Angular frequency, measured minus predicted", "rad/s"],
    ["growth_rate_inside", "Growth rate within 2 sd", "1"],
    ["angular_frequency_inside", "Angular frequency within 2 sd", "1"],
    ["trained", "Trained on", "1"],
    ["helmholtz", "Helmholtz number omega L/c of what was measured", "1"],
];

impl Run {
    fn prediction(
        &self,
        question: &Question,
        points: &Selection,
        trained_on: Option<&Selection>,
    ) -> Result<Found, EngineError> {
        let no_point = || EngineError::NothingToAnswer { question: question.id.clone() };
        let chosen = self.chosen(&question.stage).ok_or_else(no_point)?;
        let few = match trained_on {
            Some(selection) => {
                let meant = |o: &&Observed| selection.holds(&self.study.campaign, &o.conditions.point);
                let few: Vec<Observed> = chosen.observed.iter().filter(meant).cloned().collect();
                if few.is_empty() {
                    return Err(no_point());
                }
                Arc::new(few)
            }
            None => chosen.observed.clone(),
        };
        let trained = self.trained_for_predictions(&question.stage, &few)?;
        let law = self.law_error(&question.stage);
        let posterior = trained.posterior();
        let misfit = self.misfit_of(&question.stage, &trained, &few);
        let used: Vec<String> = few.iter().map(|o| o.conditions.id.clone()).collect();
        let followed = Followed::of(&self.study, &self.observed, &used);
        let seen = selected(&self.study, &self.observed, points);
        let mut all: Vec<One<'_>> = seen
            .iter()
            .map(|o| (o.conditions.clone(), o.mode.label.clone(), Some(o.near), Some(o)))
            .collect();
        for c in self.unseen(points, &seen) {
            let sought = followed.sought(&chosen.assembly, trained.best(), &c)?;
            all.extend(sought.into_iter().map(|mode| (c.clone(), mode.label, mode.near, None)));
        }
        if all.is_empty() {
            return Err(no_point());
        }
        let one = |(conditions, mode, near, observed): &One<'_>| {
            let heard = self.reference();
            let p = posterior.predict(&chosen.assembly, conditions, heard.as_slice(), *near, law.as_ref())?;
            let used = few.iter().any(|o| o.conditions.id == conditions.id);
            let numbers = numbers(&p, &misfit, conditions, *observed, used);
            Ok(self.row_of(question, &conditions.point, mode, &numbers))
        };
        let rows = all.par_iter().map(one).in_order::<Result<Vec<_>, EngineError>>()?;
        let mut columns = [self.factor_columns(), measured_columns()].concat();
        let first = self.study.campaign.factors.len();
        let predicted = columns.len();
        columns.extend(COLUMNS.map(|[name, label, unit]| FrameColumn::new(name, label, unit)));
        let axis = self.axis(question, all.iter().map(|(c, ..)| &c.point));
        let layer =
            (0, LayerLook::Band, [predicted, predicted + 2], [Some(predicted + 1), Some(predicted + 3)]);
        let panels = axis.map_or_else(Vec::new, |k| {
            let modes = apart(all.iter().map(|(c, mode, ..)| (mode.as_str(), c.point.factors[k])));
            growth_and_frequency(&axis_label(&columns[k]), k, first, &[layer], &modes)
        });
        let caption = caption(&chosen.assembly.ids().join(", "), few.len());
        let free = chosen.assembly.parameters();
        Ok((vec![Frame { columns, rows }], panels, parameters(&trained, free), caption))
    }

    /// The points of a selection that were not measured, where something is known of their gas.
    fn unseen(&self, points: &Selection, seen: &[Observed]) -> Vec<Arc<Conditions>> {
        let all = self.study.campaign.points.iter().enumerate();
        let unseen = all
            .filter(|(_, p)| points.holds(&self.study.campaign, p))
            .filter(|(_, p)| seen.iter().all(|o| o.conditions.id != p.id));
        let known =
            |(k, p)| conditions(&self.study, p, self.states.get(&k), self.ambient[k]).ok().map(Arc::new);
        unseen.filter_map(known).collect()
    }
}

/// What was measured of a mode and what is predicted, in the order of the columns.
fn numbers(
    predicted: &PointPrediction,
    misfit: &Misfit,
    conditions: &Conditions,
    observed: Option<&Observed>,
    trained: bool,
) -> Vec<f64> {
    let m = observed.map_or([f64::NAN; 4], measured);
    let s = [predicted.values[0], predicted.values[1]];
    let sd = [0, 1].map(|k| predicted.sd(k, misfit));
    let of_the_model = [0, 1].map(|k| predicted.sd(k, &Misfit::default()));
    let residual = [m[0] - s[0], m[2] - s[1]];
    let inside = [0, 1].map(|k| {
        if residual[k].is_nan() { f64::NAN } else { f64::from(u8::from(residual[k].abs() < 2.0 * sd[k])) }
    });
    let helmholtz = m[2] * conditions.layout.length / conditions.base.at(0.0).sound_speed;
    [
        &m[..],
        &[s[0], sd[0], s[1], sd[1]],
        &of_the_model,
        &residual,
        &inside,
        &[f64::from(u8::from(trained)), helmholtz],
    ]
    .concat()
}

/// `trained` is the number of observations.
fn caption(model: &str, trained: usize) -> String {
    if trained == 0 {
        return format!(
            "Predictions with two standard deviations (bands), by the model {model}. No mode was measured here."
        );
    }
    format!(
        "Measured modes (dots) and predictions with two standard deviations of a new measurement (bands), by the model {model}, trained \
         on {trained} observations."
    )
}
