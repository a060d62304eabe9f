//! What the data of a trained model still ask for: terms that nobody put into it, judged without a refit.
//!
//! For every term of a library the adjoint gives the change of all data at strength zero. What the parameters can do as well is taken out of
//! it, and the rest is held against the residuals: a score test (C. R. Rao, Proc. Camb. Phil. Soc. 44 (1948) 50). The gain is the
//! logarithm of the Bayes factor for the model with the term, whose strength has the prior of unit information; noise that floats is chosen
//! again. Probabilities are those of the largest gain of all terms in data drawn by the model itself, so that looking
//! elsewhere is paid for (R. Davies, Biometrika 74 (1987) 33, by simulation).

mod judge;
mod library;
#[cfg(test)]
mod tests;

use super::stages::{Chosen, Run};
use crate::EngineError;
use crate::observed::Used;
use judge::judged;
use library::Library;
use rijke_study::plan::Stage;
use serde::{Deserialize, Serialize};

/// What the data still ask for after a model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Missing {
    /// How many terms were tried.
    pub tried: usize,
    /// The gain that the best of all terms reaches by chance in one of twenty data sets of the model itself, nats.
    pub by_chance: f64,
    /// Families of terms, in the order in which each gains most beyond those before it.
    pub families: Vec<Family>,
    /// Of each kind of effect at each place the term of the largest gain, the most gain first.
    pub best: Vec<Asked>,
}

/// Terms that these data cannot tell apart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Family {
    /// The term of the largest gain.
    pub first: Asked,
    /// Its gain beyond the families before it, nats, noise as fitted; and the probability that the best of all terms does as well by chance.
    pub beyond: (f64, f64),
    /// Others like it, in words, the most gain first.
    pub like: Vec<String>,
    /// Where along the rig terms of the same effect are like it, m; none for what acts along it.
    pub between: Option<[f64; 2]>,
}

/// A term with what the data say of it. It describes what is missing, and is no cause.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Asked {
    /// What it does.
    pub effect: String,
    /// Where.
    pub place: String,
    /// Where along the rig, m, in the mean over the observations.
    pub x: Option<f64>,
    /// What it is in proportion to; empty if it is the same at all points.
    pub times: String,
    /// Its strength and the standard deviation of that, the parameters of the model being free to follow.
    pub strength: [f64; 2],
    /// Unit of the strength.
    pub unit: String,
    /// Standard deviation of the prior of the strength.
    pub prior_sd: f64,
    /// Expected gain in ln evidence, nats: noise chosen again.
    pub gain: f64,
    /// Probability that the best term of the library does as well by chance.
    pub probability: f64,
    /// Root mean square change of growth rates (1/s) and of angular frequencies (rad/s) at that strength, before parameters follow.
    pub moves: [f64; 2],
}

impl Asked {
    /// The term in words.
    #[must_use]
    pub fn words(&self) -> String {
        words(&self.effect, &self.place, &self.times)
    }
}

impl Run {
    /// What the data of a stage still ask for after the model that goes on.
    ///
    /// # Errors
    /// Those of the model.
    pub(super) fn missing(&self, stage: &Stage, chosen: &Chosen) -> Result<Option<Missing>, EngineError> {
        let microphones = self.microphones(stage);
        let reference = self.rig.microphones.reference;
        let used: Vec<Used> = chosen.observed.iter().map(|o| o.used(&microphones, reference)).collect();
        let (linear, _) = &*chosen.trained.linear;
        let rows = chosen.rows(&used);
        let values = &chosen.trained.values[..chosen.trained.own];
        let library =
            Library::of(&chosen.assembly, &self.study.campaign, &chosen.observed, &used, values, &rows)?;
        Ok(judged(linear, library, &rows, chosen.observed.len()))
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

fn words(effect: &str, place: &str, times: &str) -> String {
    let by = if times.is_empty() { String::new() } else { format!(", times {times}") };
    format!("{effect} at {place}{by}")
}
