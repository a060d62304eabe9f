//! Predictions of the model that a stage chose, trained on its points or on a few (Figs. 5 and 8 to 11 of
//! Juniper & Yoko 2022).

use super::super::course::{Chosen, Elsewhere, Run};
use super::super::followed::Followed;
use super::super::frame::{Frame, FrameColumn};
use super::super::inputs::{conditions, selected};
use super::super::record::parameters;
use super::axes::{apart, axis_label, growth_and_frequency, measured, measured_columns};
use super::{Found, LayerLook};
use crate::rows::Choice;
use crate::{Conditions, EngineError, Misfit, Noise, Observed, Trained, train};
use rayon::prelude::*;
use rijke_numerics::C64;
use rijke_study::plan::{Question, Selection, Stage};
use std::sync::Arc;

/// Where a mode is predicted, its label, where it is sought, and what was measured of it.
type One<'a> = (Arc<Conditions>, String, Option<C64>, Option<&'a Observed>);

impl Run {
    pub(super) fn prediction(
        &self,
        question: &Question,
        points: &Selection,
        trained_on: Option<&Selection>,
    ) -> Result<Found, EngineError> {
        let no_point = || EngineError::NoPoint { stage: question.id.clone() };
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
        let seen = selected(&self.study, &self.observed, points);
        let campaign = self.study.campaign.points.iter().enumerate();
        let unseen = campaign
            .filter(|(_, p)| points.holds(&self.study.campaign, p))
            .filter(|(_, p)| seen.iter().all(|o| o.conditions.id != p.id));
        // A point that was not measured and of whose gas nothing is known is not predicted.
        let unseen = unseen.filter_map(|(k, p)| {
            let found = conditions(&self.study, p, self.states.get(&k), self.ambient[k]);
            found.ok().map(Arc::new)
        });
        let used: Vec<String> = few.iter().map(|o| o.conditions.id.clone()).collect();
        let followed = Followed::of(&self.study, &self.observed, &used);
        let mut all: Vec<One<'_>> = seen
            .iter()
            .map(|o| (o.conditions.clone(), o.mode.label.clone(), Some(o.near), Some(o)))
            .collect();
        let values = &trained.values[..trained.own];
        for c in unseen {
            let sought = followed.sought(&chosen.assembly, values, &c)?;
            all.extend(sought.into_iter().map(|(label, near)| (c.clone(), label, near, None)));
        }
        if all.is_empty() {
            return Err(no_point());
        }
        let one = |(conditions, mode, near, observed): &One<'_>| {
            let heard = self.reference();
            let p = posterior.predict(&chosen.assembly, conditions, heard.as_slice(), *near, law.as_ref())?;
            let m = observed.map_or([f64::NAN; 4], measured);
            let (s, sd) = ([p.values[0], p.values[1]], [0, 1].map(|k| p.sd(k, &misfit)));
            let of_the_model = [0, 1].map(|k| p.sd(k, &Misfit::default()));
            let residual = [m[0] - s[0], m[2] - s[1]];
            let inside = [0, 1].map(|k| {
                if residual[k].is_nan() {
                    f64::NAN
                } else {
                    f64::from(u8::from(residual[k].abs() < 2.0 * sd[k]))
                }
            });
            let used = few.iter().any(|o| o.conditions.id == conditions.id);
            let c_in = conditions.base.at(0.0).sound_speed;
            let helmholtz = m[2] * conditions.layout.length / c_in;
            let numbers = [
                &m[..],
                &[s[0], sd[0], s[1], sd[1]],
                &of_the_model,
                &residual,
                &inside,
                &[f64::from(u8::from(used)), helmholtz],
            ]
            .concat();
            Ok(self.row_of(question, &conditions.point, mode, &numbers))
        };
        let rows = all.par_iter().map(one).collect::<Result<Vec<_>, EngineError>>()?;
        let mut columns = [self.factor_columns(), measured_columns()].concat();
        let first = self.study.campaign.factors.len();
        let predicted = columns.len();
        for (name, label, unit) in [
            ("predicted_growth_rate", "Growth rate, predicted", "1/s"),
            ("predicted_growth_rate_sd", "Growth rate, sd of a new measurement", "1/s"),
            ("predicted_angular_frequency", "Angular frequency, predicted", "rad/s"),
            ("predicted_angular_frequency_sd", "Angular frequency, sd of a new measurement", "rad/s"),
            ("model_growth_rate_sd", "Growth rate, sd of the model", "1/s"),
            ("model_angular_frequency_sd", "Angular frequency, sd of the model", "rad/s"),
            ("growth_rate_residual", "Growth rate, measured minus predicted", "1/s"),
            ("angular_frequency_residual", "Angular frequency, measured minus predicted", "rad/s"),
            ("growth_rate_inside", "Growth rate within 2 sd", "1"),
            ("angular_frequency_inside", "Angular frequency within 2 sd", "1"),
            ("trained", "Trained on", "1"),
            ("helmholtz", "Helmholtz number omega L/c of what was measured", "1"),
        ] {
            columns.push(FrameColumn::new(name, label, unit));
        }
        let axis = self.axis(question, all.iter().map(|(c, ..)| &c.point));
        let layer =
            (0, LayerLook::Band, [predicted, predicted + 2], [Some(predicted + 1), Some(predicted + 3)]);
        let panels = axis.map_or_else(Vec::new, |k| {
            let modes = apart(all.iter().map(|(c, mode, ..)| (mode.as_str(), c.point.factors[k])));
            growth_and_frequency(&axis_label(&columns[k]), k, first, &[layer], &modes)
        });
        let model = chosen.assembly.ids().join(", ");
        let caption = if few.is_empty() {
            format!(
                "Predictions with two standard deviations (bands), by the model {model}. No mode was measured here."
            )
        } else {
            format!(
                "Measured modes (dots) and predictions with two standard deviations of a new measurement (bands), by the model {model}, trained \
                 on {} observations.",
                few.len()
            )
        };
        let free = chosen.assembly.parameters();
        Ok((vec![Frame { columns, rows }], panels, parameters(&trained, free), caption))
    }

    /// The model that goes on from a stage, trained with what enters predictions but not the comparison; none
    /// before the stage has run.
    ///
    /// # Errors
    /// Those of training.
    pub fn for_predictions(&self, id: &str) -> Result<Option<Chosen>, EngineError> {
        let Some(chosen) = self.chosen(id) else { return Ok(None) };
        let trained = self.trained_for_predictions(id, &chosen.observed)?;
        Ok(Some(Chosen { trained, ..chosen.clone() }))
    }

    /// What a new measurement differs by from `chosen` of a stage, as far as its points tell.
    #[must_use]
    pub fn misfit_of_predictions(&self, id: &str, chosen: &Chosen) -> Misfit {
        self.misfit_of(id, &chosen.trained, &chosen.observed)
    }

    fn misfit_of(&self, id: &str, trained: &Trained, points: &[Observed]) -> Misfit {
        let adds = self.study.plan.stage(id).is_some_and(|(_, stage)| added(stage));
        Misfit::of_a_new_measurement(&trained.noise, points, adds)
    }

    /// The model that goes on from a stage, to be kept on disk.
    ///
    /// # Errors
    /// [`EngineError::NoPoint`] if the stage has not run, and those of training.
    pub fn saved(&self, id: &str) -> Result<crate::SavedModel, EngineError> {
        let no_stage = || EngineError::NoPoint { stage: id.to_owned() };
        let (_, stage) = self.study.plan.stage(id).ok_or_else(no_stage)?;
        let done = self.stage_done(id).ok_or_else(no_stage)?;
        let trained = self.trained_for_predictions(id, &done.chosen.observed)?;
        let mut model = self.kept(stage, &done.choice, &done.chosen, &trained);
        model.assumes.clone_from(&done.assumes);
        Ok(model)
    }

    /// The best model of a stage but the one that goes on, to be kept on disk; none where no other could be
    /// fitted. It is trained with what enters predictions, as the one that goes on.
    ///
    /// # Errors
    /// Those of training.
    pub fn saved_rival(&self, id: &str) -> Result<Option<crate::SavedModel>, EngineError> {
        let (Some((_, stage)), Some(done)) = (self.study.plan.stage(id), self.stage_done(id)) else {
            return Ok(None);
        };
        done.rival().map(|(model, chosen)| self.saved_of(stage, &model.candidates, chosen)).transpose()
    }

    /// A model of a stage, trained with what enters predictions, to be kept on disk.
    pub(in super::super) fn saved_of(
        &self,
        stage: &Stage,
        choice: &Choice,
        chosen: &Chosen,
    ) -> Result<crate::SavedModel, EngineError> {
        let trained = match stage.noise_of_predictions {
            Some(_) => {
                Arc::new(self.trained_with_noise_of_predictions(stage, chosen, &chosen.observed, None)?)
            }
            None => chosen.trained.clone(),
        };
        Ok(self.kept(stage, choice, chosen, &trained))
    }

    /// The model at another maximum of its posterior, as it is kept on disk.
    ///
    /// # Errors
    /// Those of training.
    pub(in super::super) fn saved_elsewhere(
        &self,
        stage: &Stage,
        chosen: &Chosen,
        maximum: &Elsewhere,
    ) -> Result<crate::SavedModel, EngineError> {
        let there = Chosen { known: maximum.known.clone(), ..chosen.clone() };
        let start = Some(maximum.at.clone());
        let trained = self.trained_with_noise_of_predictions(stage, &there, &chosen.observed, start)?;
        Ok(self.kept(stage, &chosen.choice(), &there, &trained))
    }

    fn kept(&self, stage: &Stage, choice: &Choice, chosen: &Chosen, trained: &Trained) -> crate::SavedModel {
        let mut points: Vec<String> = chosen.observed.iter().map(|o| o.conditions.id.clone()).collect();
        points.dedup();
        let (hold, law) = (stage.hold.clone(), self.law_in_predictions(stage, choice));
        let grounds = self.study.plan.grounds(stage).into_iter().filter_map(|id| self.ground(id)?.band_hz);
        let measured_hz = grounds.reduce(|[a, b], [low, high]| [a.max(low), b.min(high)]);
        let of = crate::SavedModel::of;
        let mut saved = of(&stage.id, choice.clone(), hold, points, trained, law, added(stage));
        saved.measured_hz = measured_hz;
        saved
    }

    /// Searched from `start`, parameters of the model, if it is given.
    fn trained_with_noise_of_predictions(
        &self,
        stage: &Stage,
        chosen: &Chosen,
        points: &[Observed],
        start: Option<Vec<f64>>,
    ) -> Result<Trained, EngineError> {
        let spec = stage.noise_of_predictions.as_ref().unwrap_or(&stage.noise);
        let choice = chosen.choice();
        let noise = Noise { law: self.law_of(stage, spec, &choice)?, ..self.noise(spec)? };
        let mut training = self.training(stage, noise, chosen.known.to_vec(), super::super::Trusted::Laplace);
        training.search.start = start;
        train(&chosen.assembly, points, &training)
    }

    /// The model that goes on from a stage, trained on `points` with what enters predictions but not the
    /// comparison.
    fn trained_for_predictions(
        &self,
        id: &str,
        points: &Arc<Vec<Observed>>,
    ) -> Result<Arc<Trained>, EngineError> {
        let no_stage = || EngineError::NoPoint { stage: id.to_owned() };
        let (_, stage) = self.study.plan.stage(id).ok_or_else(no_stage)?;
        let chosen: &Chosen = self.chosen(id).ok_or_else(no_stage)?;
        let all = Arc::ptr_eq(points, &chosen.observed);
        if stage.noise_of_predictions.is_none() && all {
            return Ok(chosen.trained.clone());
        }
        let before = || self.predicting.lock().ok()?.get(id).cloned();
        if let Some(trained) = before().filter(|_| all) {
            return Ok(trained);
        }
        let trained = Arc::new(self.trained_with_noise_of_predictions(stage, chosen, points, None)?);
        if let (Ok(mut kept), true) = (self.predicting.lock(), all) {
            kept.insert(id.to_owned(), trained.clone());
        }
        Ok(trained)
    }

    /// The error of laws that enters the predictions of a stage.
    #[must_use]
    pub fn law_error(&self, id: &str) -> Option<crate::LawError> {
        let (_, stage) = self.study.plan.stage(id)?;
        self.law_in_predictions(stage, &self.stage_done(id)?.choice)
    }

    fn law_in_predictions(&self, stage: &Stage, choice: &Choice) -> Option<crate::LawError> {
        let spec = stage.noise_of_predictions.as_ref().unwrap_or(&stage.noise);
        // Training has refused what can be refused here.
        self.law_of(stage, spec, choice).ok().flatten()
    }
}

/// Whether measured errors come on top of the noise of predictions.
fn added(stage: &Stage) -> bool {
    stage.noise_of_predictions.as_ref().unwrap_or(&stage.noise).measured
}
