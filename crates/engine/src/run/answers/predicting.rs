//! The model of a stage that predicts: trained with what enters predictions but not the comparison, and as it
//! is kept on disk.

use super::super::course::{Chosen, Elsewhere, Run};
use crate::rows::Choice;
use crate::{EngineError, Misfit, Observed, Trained};
use rijke_study::plan::Stage;
use std::sync::Arc;

impl Run {
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

    pub(super) fn misfit_of(&self, id: &str, trained: &Trained, points: &[Observed]) -> Misfit {
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
            Some(_) => Arc::new(self.trained_with_noise_of_predictions(
                stage,
                chosen,
                &chosen.observed,
                chosen.trained.best(),
            )?),
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
        let trained = self.trained_with_noise_of_predictions(stage, &there, &chosen.observed, &maximum.at)?;
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

    /// Searched from `start`, parameters of the model: a search from elsewhere may end in another maximum
    /// than the one that was ranked.
    fn trained_with_noise_of_predictions(
        &self,
        stage: &Stage,
        chosen: &Chosen,
        points: &[Observed],
        start: &[f64],
    ) -> Result<Trained, EngineError> {
        let spec = stage.noise_of_predictions.as_ref().unwrap_or(&stage.noise);
        self.trained_again(stage, spec, chosen, points, start)
    }

    /// The model that goes on from a stage, trained on `points` with what enters predictions but not the
    /// comparison.
    pub(super) fn trained_for_predictions(
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
        let trained =
            Arc::new(self.trained_with_noise_of_predictions(stage, chosen, points, chosen.trained.best())?);
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
