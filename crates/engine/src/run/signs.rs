//! Whether growth rates have the wrong sign: by training again with the other one.

use super::course::{Chosen, Run, StandsOn, Trusted};
use crate::noise::measured_sd;
use crate::rows::Row;
use crate::{EngineError, Observed};
use rijke_numerics::C64;
use rijke_study::plan::Stage;
use std::sync::Arc;

/// A misfit of growth rates, in measured standard deviations, that asks for the question.
const LARGE: f64 = 3.0;

/// Nats by which the other sign must lead.
const LEADS: f64 = 10.0;

impl Run {
    /// Where all growth rates are positive and a model misses them by far: what it gains if they are decay
    /// rates, in a sentence. Nothing if that gains less than [`LEADS`].
    ///
    /// # Errors
    /// [`EngineError::Stopped`].
    pub(super) fn turned(
        &self,
        stage: &Stage,
        row: &Row,
        found: &Chosen,
    ) -> Result<Option<String>, EngineError> {
        let rates: Vec<f64> = found.observed.iter().filter_map(|o| o.mode.growth_rate).collect();
        let grow = rates.len() > 1 && rates.iter().all(|g| *g > 0.0);
        if !(grow && found.misfit[0] > LARGE * measured_sd(&found.observed, 0)) {
            return Ok(None);
        }
        self.go_on()?;
        let turned = |o: &Observed| {
            let mut o = o.clone();
            o.mode.growth_rate = o.mode.growth_rate.map(|g| -g);
            o.near = C64::new(-o.near.re, o.near.im);
            for (k, other) in (1..o.mode.covariance.rows()).map(|k| (0, k)) {
                for place in [(k, other), (other, k)] {
                    o.mode.covariance[place] = -o.mode.covariance[place];
                }
            }
            o
        };
        let points = Arc::new(found.observed.iter().map(turned).collect());
        let stands_on = StandsOn::one(found.known.clone(), points);
        let Ok(other) = self.train_row(stage, row, stands_on, Trusted::Laplace) else { return Ok(None) };
        let gain = other.trained.evidence.ln_marginal - found.trained.evidence.ln_marginal;
        Ok((gain > LEADS).then(|| {
            format!(
                "with the signs of all growth rates turned this model gains {gain:.1} nats: the growth rate of a mode that decays is negative; if the \
                 column holds decay rates, turn their signs"
            )
        }))
    }
}
