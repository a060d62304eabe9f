//! Rows that a study needs in several of its courses, each trained once: a model that is carried on through
//! later stages is, as a rule, the one that goes on, and then its rows are those of the stages themselves.

use super::course::{Found, Kept, Run, Trusted};
use crate::rows::Row;
use crate::{EngineError, Trained};
use rijke_study::plan::Stage;
use std::sync::{Arc, PoisonError};

impl Run {
    /// What `train` finds of a row on the models that the stages before have chosen; as it was found before,
    /// if it was trained on the same ones. A search that begins near another one is not kept.
    ///
    /// # Errors
    /// Those of `train`.
    pub(super) fn once(
        &self,
        stage: &Stage,
        row: &Row,
        trusted: Trusted,
        train: impl FnOnce() -> Result<Found, EngineError>,
    ) -> Result<Found, EngineError> {
        if !self.near.is_empty() {
            return train();
        }
        let on: Vec<&Arc<Trained>> = self.done.iter().map(|done| &done.chosen.trained).collect();
        let (key, trusted) = ((stage.id.clone(), row.choice.clone()), [trusted, self.trusted]);
        let same = |kept: &&Kept| {
            let pairs = || kept.on.iter().zip(&on);
            kept.trusted == trusted && kept.on.len() == on.len() && pairs().all(|(a, b)| Arc::ptr_eq(a, b))
        };
        let kept = || self.once.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = kept().get(&key).and_then(|all| all.iter().find(same)) {
            return Ok(known.found.clone());
        }
        let found = train()?;
        let mut kept = kept();
        let all = kept.entry(key).or_default();
        all.retain(|kept| kept.trusted != trusted);
        all.push(Kept { trusted, on: on.into_iter().cloned().collect(), found: found.clone() });
        Ok(found)
    }
}
