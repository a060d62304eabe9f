//! What a set of visits would tell, by a model and its rival.

use super::predictive::Predictive;
use crate::EngineError;
use serde::Serialize;

/// What further measurements are for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Aim {
    /// To know the parameters of the model that went on.
    #[default]
    Parameters,
    /// To tell it from its rival.
    Models,
    /// To know its growth rate at a point that is not measured.
    Quantity,
}

/// The predictives of all visits that can be made.
pub(super) struct Told {
    pub(super) mine: Predictive,
    pub(super) rival: Option<Predictive>,
    /// The place of the quantity among the points.
    pub(super) quantity: Option<usize>,
}

impl Told {
    pub(super) fn models(&self, set: &[usize]) -> Result<Option<[f64; 2]>, EngineError> {
        let Some(rival) = &self.rival else { return Ok(None) };
        Ok(Some([self.mine.divergence(rival, set)?, rival.divergence(&self.mine, set)?]))
    }

    /// Mean and standard deviation of the logarithm of the Bayes factor for whichever is right: the model, or its rival.
    pub(super) fn factor(&self, set: &[usize]) -> Result<Option<[[f64; 2]; 2]>, EngineError> {
        let (Some(means), Some(rival)) = (self.models(set)?, &self.rival) else { return Ok(None) };
        let spreads = [self.mine.spread(rival, set)?, rival.spread(&self.mine, set)?];
        Ok(Some([[means[0], spreads[0]], [means[1], spreads[1]]]))
    }

    pub(super) fn about(&self, set: &[usize]) -> Result<Option<f64>, EngineError> {
        let Some(quantity) = self.quantity else { return Ok(None) };
        let [before, after] = self.mine.variances(quantity, set)?;
        Ok(Some(0.5 * (before / after).ln()))
    }

    pub(super) fn gain(&self, aim: Aim, set: &[usize]) -> Result<f64, EngineError> {
        Ok(match aim {
            Aim::Parameters => self.mine.information(set)?,
            // Whichever of the two is right, so much is expected at least.
            Aim::Models => self.models(set)?.map_or(0.0, |[a, b]| a.min(b)),
            Aim::Quantity => self.about(set)?.unwrap_or(0.0),
        })
    }
}
