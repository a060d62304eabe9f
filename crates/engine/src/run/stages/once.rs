//! Rows that are needed more than once, each trained once. The model that goes on is carried through later
//! stages first, and these stages then need the same rows.

use super::super::course::{Found, Kept, Run, Trusted};
use crate::rows::Row;
use crate::{EngineError, Trained};
use rijke_study::plan::Stage;
use std::sync::{Arc, PoisonError};

impl Run {
    /// What `train` finds of a row. A row that was trained before on the same models of earlier stages is not
    /// trained again. Nothing is kept of a search that begins near another one.
    ///
    /// # Errors
    /// Those of `train`.
    pub(in crate::run) fn once(
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
