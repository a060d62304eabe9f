//! What a set of visits would tell, by a model and its rival.

use super::predictive::Predictive;
use crate::EngineError;
use rijke_numerics::Matrix;
use serde::Serialize;

/// What further measurements are for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Aim {
    /// To know the parameters of the model that went on.
    #[default]
    Parameters,
    /// To tell it from its rival, or which of several open models is right.
    Models,
    /// To know its growth rate at a point that is not measured.
    Quantity,
}

/// The predictives of all visits that can be made.
pub(super) struct Told {
    pub(super) mine: Predictive,
    /// Those of other models, the most probable first, with odds against the first one.
    pub(super) rivals: Vec<(f64, Predictive)>,
    /// The place of the quantity among the points.
    pub(super) quantity: Option<usize>,
}

impl Told {
    pub(super) fn models(&self, set: &[usize]) -> Result<Option<[f64; 2]>, EngineError> {
        let Some((_, rival)) = self.rivals.first() else { return Ok(None) };
        Ok(Some([self.mine.divergence(rival, set)?, rival.divergence(&self.mine, set)?]))
    }

    /// What is told of which model is right, where several are open: at least -sum_i w_i ln sum_j w_j
    /// exp(-B_ij) nats, with the probabilities w of the models and Bhattacharyya's distances B of their
    /// predictives (Kolchinsky & Tracey 2017), and never more than [the entropy](Self::entropy) of the
    /// probabilities.
    pub(super) fn which(&self, set: &[usize]) -> Result<Option<f64>, EngineError> {
        if self.rivals.len() < 2 {
            return Ok(None);
        }
        let all: Vec<&Predictive> =
            std::iter::once(&self.mine).chain(self.rivals.iter().map(|(_, p)| p)).collect();
        let seen = all.iter().map(|p| p.seen(set)).collect::<Result<Vec<_>, _>>()?;
        let weights = self.weights();
        let mut overlap = Matrix::identity(all.len());
        for i in 0..all.len() {
            for j in 0..i {
                let shared = (-seen[i].distance(&seen[j])?).exp();
                (overlap[(i, j)], overlap[(j, i)]) = (shared, shared);
            }
        }
        let told = weights.iter().zip(overlap.times(&weights)).map(|(w, sum)| -w * sum.ln());
        Ok(Some(told.sum()))
    }

    /// The entropy of the probabilities of the models, nats: all that can be told of which is right.
    pub(super) fn entropy(&self) -> f64 {
        self.weights().iter().filter(|w| **w > 0.0).map(|w| -w * w.ln()).sum()
    }

    fn weights(&self) -> Vec<f64> {
        let odds = || std::iter::once(1.0).chain(self.rivals.iter().map(|(odds, _)| *odds));
        let sum: f64 = odds().sum();
        odds().map(|w| w / sum).collect()
    }

    /// Mean and standard deviation of the logarithm of the Bayes factor for whichever is right: the model, or
    /// its rival.
    pub(super) fn factor(&self, set: &[usize]) -> Result<Option<[[f64; 2]; 2]>, EngineError> {
        let (Some(means), Some((_, rival))) = (self.models(set)?, self.rivals.first()) else {
            return Ok(None);
        };
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
            Aim::Models => match self.which(set)? {
                Some(told) => told,
                None => self.models(set)?.map_or(0.0, |[a, b]| a.min(b)),
            },
            Aim::Quantity => self.about(set)?.unwrap_or(0.0),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::predictive::Numbers;
    use super::*;
    use rand_distr::{Distribution, StandardNormal};
    use rijke_numerics::{Stream, Streams};

    /// Three models that read one number, means and standard deviations.
    const MODELS: [[f64; 2]; 3] = [[0.0, 1.0], [1.8, 0.7], [-1.0, 1.6]];
    const ODDS: [f64; 2] = [0.6, 0.3];

    fn predictive([mean, sd]: [f64; 2]) -> Predictive {
        let noise = Matrix::diagonal(&[sd * sd]);
        let visit = Numbers { values: vec![mean], noise, stays: Matrix::zeros(1, 1), ..Numbers::default() };
        Predictive::new(vec![visit], &Matrix::identity(1))
    }

    /// By draws, without any distance of Gaussians; two visits.
    #[test]
    fn oracle_which_model_is_right_is_bounded_by_monte_carlo() {
        let rivals = [1, 2].map(|k| (ODDS[k - 1], predictive(MODELS[k])));
        let told = Told { mine: predictive(MODELS[0]), rivals: rivals.into(), quantity: None };
        let sum = 1.0 + ODDS[0] + ODDS[1];
        let weights = [1.0, ODDS[0], ODDS[1]].map(|w| w / sum);
        let density = |y: &[f64], [mean, sd]: [f64; 2]| {
            y.iter().map(|y| (-0.5 * ((y - mean) / sd).powi(2)).exp() / sd).product::<f64>()
        };
        let mut stream: Stream = Streams::new(5).stream("next/which");
        for visits in [1, 2, 4] {
            let (mut sampled, draws) = (0.0, 60_000);
            for (w, [mean, sd]) in weights.iter().zip(MODELS) {
                for _ in 0..draws {
                    let mut one = || -> f64 { StandardNormal.sample(&mut stream) };
                    let y: Vec<f64> = (0..visits).map(|_| mean + sd * one()).collect();
                    let mixed: f64 = weights.iter().zip(MODELS).map(|(w, m)| w * density(&y, m)).sum();
                    sampled += w * (density(&y, [mean, sd]) / mixed).ln() / f64::from(draws);
                }
            }
            let bound = told.which(&vec![0; visits]).unwrap().unwrap();
            assert!(bound < sampled && bound > 0.65 * sampled, "{visits}: {bound} {sampled}");
            assert!(sampled < told.entropy());
        }
        let many = told.which(&[0; 200]).unwrap().unwrap();
        assert!((many / told.entropy() - 1.0).abs() < 1e-3, "{many} {}", told.entropy());
    }

    #[test]
    fn exact_models_that_agree_are_not_told_apart() {
        let rivals = vec![(0.5, predictive(MODELS[0])), (0.2, predictive(MODELS[0]))];
        let told = Told { mine: predictive(MODELS[0]), rivals, quantity: None };
        assert!(told.which(&[0, 0]).unwrap().unwrap().abs() < 1e-12);
    }
}
