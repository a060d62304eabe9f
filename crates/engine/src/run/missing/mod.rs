//! What the data of a trained model still ask for: terms that nobody put into it, judged without a refit.
//!
//! For every term of a library the adjoint gives the change of all data at strength zero. What the parameters
//! can do as well is taken out of it, and the rest is held against the residuals: a score test (C. R. Rao,
//! Proc. Camb. Phil. Soc. 44 (1948) 50). The gain is the logarithm of the Bayes factor for the model with the
//! term, whose strength has the prior of unit information; noise that floats is chosen again. Probabilities
//! are those of the largest gain of all terms in data drawn by the model itself, so that looking elsewhere is
//! paid for (R. Davies, Biometrika 74 (1987) 33, by simulation).
//!
//! Knows one trained model and its data, and no candidate but its own: a term that is found is a description.

mod factors;
mod judge;
mod library;
#[cfg(test)]
mod tests;

use super::course::{Chosen, Run};
use super::found::{Asked, Missing};
use crate::EngineError;
use crate::observed::Used;
use judge::judged;
use library::Library;
use rijke_study::plan::Stage;

impl Run {
    /// What the data of a stage still ask for after the model that goes on.
    ///
    /// # Errors
    /// Those of the model.
    pub(super) fn missing(&self, stage: &Stage, chosen: &Chosen) -> Result<Option<Missing>, EngineError> {
        let used = chosen.used(&self.rig, stage);
        // Where points are many, training takes what a shared error does to the pressures of each for an
        // error of its own: a term that does the same at all points would seem certain.
        let linear = chosen.trained.linear.0.with_shared(&chosen.trained.told.apart)?;
        let rows = chosen.rows(&used);
        let values = chosen.trained.best();
        let library =
            Library::of(&chosen.assembly, &self.study.campaign, &chosen.observed, &used, values, &rows)?;
        let mut missing = judged(&linear, library, &rows, chosen.observed.len());
        // Of others no earlier stage says what they are.
        let grounds = || self.study.plan.grounds(stage).into_iter().filter_map(|id| self.ground(id));
        let measured = |law: &Asked| {
            let models = || grounds().flat_map(|ground| &ground.models);
            models().any(|m| m.candidates.values().any(|id| law.effect.ends_with(&format!(" of {id}"))))
        };
        if let Some(missing) = &mut missing {
            missing.laws.retain(measured);
        }
        Ok(missing)
    }
}

impl Chosen {
    /// The observation and the row in its prediction of every datum.
    pub(super) fn rows(&self, used: &[Used]) -> Vec<(usize, usize)> {
        let firsts: Vec<usize> = used
            .iter()
            .scan(0, |sum, u| {
                *sum += u.size();
                Some(*sum - u.size())
            })
            .collect();
        let row = |&place: &usize| {
            let k = firsts.partition_point(|first| *first <= place) - 1;
            (k, place - firsts[k])
        };
        self.trained.linear.1.iter().map(row).collect()
    }
}
