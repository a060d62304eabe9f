//! Whether the data are those of the other sign of time, asked of the best model of a stage.

use super::ground::Learned;
use super::mistaken::{best_undone, conjugated};
use super::record::ResponseModelRecord;
use super::select::Selected;
use super::stage::ResponseRun;
use super::train::ResponseTraining;
use crate::EngineError;
use crate::rows::Row;
use rijke_study::responses::ResponseStage;

impl ResponseRun {
    /// Whether the data may be those of the other sign of time, in a sentence, by a trained model that is
    /// nearly right: it may be so because a flow has turned its direction. Other mistakes leave more.
    pub(super) fn turned_time(
        &self,
        stage: &ResponseStage,
        row: &Row,
        data: &Selected,
        (record, learned): (&ResponseModelRecord, &Learned),
    ) -> Result<Option<String>, EngineError> {
        let Some(share) = learned.nearly_right else { return Ok(None) };
        let (assembly, errors) = self.assembled(stage, row)?;
        let mut responses = self.models(stage, &assembly, data)?;
        if !responses.errors.is_none() {
            responses = self.about(&assembly, data, &responses, &learned.known.mean)?;
        }
        let training = ResponseTraining {
            responses: &responses,
            measured: &data.measured,
            errors: &errors,
            parameters: &self.parameters(stage, &assembly, &responses)?,
            stage,
            starts: &[],
        };
        Ok(best_undone(&training, vec![conjugated(data)], [record.ln_evidence(), share]))
    }
}
