//! What the model of a stage of responses predicts: asked for, doubted, tabled.

use super::forecasts::how_many;
use super::responses::{ResponseResults, response_fault};
use super::results::{kept, known_stage, said_by_rank};
use super::study::{open_study, warn_of_study};
use crate::response::{Ground, ResponseForecast, trained_band};
use crate::run::{AskedPoint, beyond, with_points};
use rijke_numerics::{Classify, Failed, Tell};
use rijke_rig::files::csv_table;
use rijke_study::Study;
use rijke_study::responses::{ResponseStage, Responses};
use std::path::Path;

/// A stage of responses that was ranked.
pub struct RankedResponses {
    study: Study,
    observed: Responses,
    stage: ResponseStage,
    ground: Ground,
}

impl RankedResponses {
    /// Reads the stage `id`, or the last one of a study that has no stages of modes; none if that is no stage
    /// of responses.
    ///
    /// # Errors
    /// File and remedy.
    pub fn open(dir: &Path, id: Option<&str>, tell: &dyn Tell) -> Result<Option<Self>, Failed> {
        let mut study = open_study(dir)?;
        let plan = &study.plan;
        let stage = match id {
            Some(id) => plan.response(id),
            None => plan.responses.last().filter(|_| plan.stages.is_empty()),
        };
        if let (Some(id), true) = (id, plan.stages.is_empty()) {
            known_stage(id, &plan.responses.iter().map(|s| s.id.as_str()).collect::<Vec<_>>(), dir)?;
        }
        let Some(stage) = stage.cloned() else { return Ok(None) };
        warn_of_study(dir, tell);
        let beside =
            if plan.stages.is_empty() { Path::new("") } else { Path::new(ResponseResults::BESIDE_MODES) };
        let ground = kept(dir, &beside.join("models").display().to_string(), &stage.id)?;
        let observed = study.responses().or_bad_input()?;
        study.campaign.take_ambient(&observed.ambient);
        Ok(Some(Self { study, observed, stage, ground }))
    }

    /// Predicts at the points that are `asked` for, or at those of the stage; at these frequencies, Hz, or
    /// over those that trained.
    ///
    /// # Errors
    /// Conditions that cannot be.
    pub fn predict(
        &self,
        asked: &[AskedPoint],
        frequency_hz: &[f64],
        tell: &dyn Tell,
    ) -> Result<Vec<ResponseForecast>, Failed> {
        let wrong = |e| response_fault(&e, &self.study.folder);
        let every = self.stage.points.places(&self.study.campaign);
        let (study, places) = match asked {
            [] => (self.study.clone(), every.clone()),
            asked => with_points(&self.study, &self.stage.points, asked).map_err(wrong)?,
        };
        let trained: Vec<String> = every.iter().map(|k| study.campaign.points[*k].id.clone()).collect();
        let far = beyond(&study, &trained, &places, &[]);
        far.iter().for_each(|far| tell.note(format!("warning: {}", far.words())));
        let found = self.ground.forecast(&study, &self.observed, &places, frequency_hz).map_err(wrong)?;
        self.tell_doubts(&found, tell);
        Ok(found)
    }

    fn tell_doubts(&self, found: &[ResponseForecast], tell: &dyn Tell) {
        if found.is_empty() {
            tell.note(
                "this stage trained on pressures of unknown sources, and none of its laws is the reflection of an end: it has no number to predict".to_owned(),
            );
        }
        let undecided = self.ground.models.first().and_then(|best| self.ground.undecided(best));
        for said in self.ground.assumes.iter().chain(&undecided) {
            tell.note(format!("warning: this model stands on a choice that is not decided. {said}"));
        }
        for said in self.ground.models.first().iter().flat_map(|best| &best.doubts) {
            said_by_rank(said, tell);
        }
        if let Some(said) = self.ground.other_maxima() {
            tell.note(format!("warning: {said}"));
        }
        let Ok([low, high]) = trained_band(&self.study, &self.observed, &self.stage) else { return };
        let far = found.iter().filter(|f| !(low..=high).contains(&f.frequency_hz));
        let hertz = how_many(far.map(|f| f.frequency_hz.to_string()));
        if hertz > 0 {
            tell.note(format!(
                "warning: {hertz} of the frequencies lie beyond those that the stage was trained on, {low} to {high} Hz: the laws are extrapolated"
            ));
        }
    }

    /// Predictions as CSV, a row for each.
    ///
    /// # Errors
    /// A table that cannot be written.
    pub fn csv(&self, found: &[ResponseForecast]) -> Result<String, Failed> {
        let absorbs = found.iter().any(|f| f.is_reflection);
        let head = "point,response,frequency [Hz],real,imaginary,real_sd,imaginary_sd,modulus,modulus_sd,phase [deg],phase_sd [deg]";
        let head = head.split(',').chain(["absorption", "absorption_sd"].into_iter().filter(|_| absorbs));
        let row = |f: &ResponseForecast| {
            let numbers = [f.value, f.sd(), f.modulus()].concat();
            let angles = f.phase().map(|both| both.map(f64::to_degrees));
            let pair = |pair: Option<[f64; 2]>| {
                pair.map_or([String::new(), String::new()], |p| p.map(|v| format!("{v:.6}")))
            };
            let cells = numbers.iter().map(|v| format!("{v:.6}")).chain(pair(angles));
            let absorption = pair(f.absorption()).into_iter().filter(|_| absorbs);
            [f.point.clone(), f.what.clone(), f.frequency_hz.to_string()]
                .into_iter()
                .chain(cells)
                .chain(absorption)
                .collect()
        };
        csv_table(std::iter::once(head.map(str::to_owned).collect()).chain(found.iter().map(row)))
    }

    /// Name of the stage, and the candidates of its model.
    #[must_use]
    pub fn model(&self) -> (&str, Vec<&String>) {
        (
            &self.stage.id,
            self.ground.models.first().map(|m| m.candidates.values().collect()).unwrap_or_default(),
        )
    }
}
