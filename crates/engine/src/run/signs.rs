//! Whether growth rates have the wrong sign, or pressures the other convention of time: by training again
//! with the data turned.

use super::course::{Chosen, Run, StandsOn, Trusted};
use crate::noise::measured_sd;
use crate::observed::Used;
use crate::rows::Row;
use crate::{EngineError, Observed};
use rijke_numerics::{C64, Matrix};
use rijke_study::plan::Stage;
use std::sync::Arc;

/// A misfit of growth rates, in measured standard deviations, that asks for the question.
const LARGE: f64 = 3.0;

/// Imaginary parts of pressures, over their moduli, that say nothing of a sign.
const STANDING: f64 = 1e-3;

/// Nats by which the other sign must lead.
const LEADS: f64 = 10.0;

impl Run {
    /// What a model gains with the data turned, each in a sentence: where all growth rates are positive and
    /// it misses them by far, if they are decay rates; where its imaginary parts of the pressures are nearer
    /// to those with the other sign, or it explains nothing of the growth rates, if they are complex
    /// conjugates. Nothing of what gains less than [`LEADS`].
    ///
    /// # Errors
    /// [`EngineError::Stopped`].
    pub(super) fn turned(
        &self,
        stage: &Stage,
        row: &Row,
        found: &Chosen,
    ) -> Result<Vec<String>, EngineError> {
        let rates: Vec<f64> = found.observed.iter().filter_map(|o| o.mode.growth_rate).collect();
        let grow = rates.len() > 1 && rates.iter().all(|g| *g > 0.0);
        let mut said = Vec::new();
        if grow
            && found.misfit[0] > LARGE * measured_sd(&found.observed, 0)
            && let Some(gain) = self.gain(stage, row, found, &|o| {
                o.mode.growth_rate = o.mode.growth_rate.map(|g| -g);
                o.near = C64::new(-o.near.re, o.near.im);
                turn(&mut o.mode.covariance, |k| k == 0);
            })?
        {
            said.push(format!(
                "with the signs of all growth rates turned this model gains {gain:.1} nats: the growth rate of a mode that decays is negative; if the \
                 column holds decay rates, turn their signs"
            ));
        }
        // A flexible model takes up phases of the wrong sign, at the cost of the growth rates.
        let pressures = found.observed.iter().flat_map(|o| &o.mode.pressures);
        let standing = pressures.clone().all(|(_, p)| p.im.abs() < STANDING * p.norm());
        let least = spread(&rates).max(LARGE * measured_sd(&found.observed, 0));
        let explains_none = rates.len() > 2 && found.misfit[0] > least;
        if (self.nearer_conjugated(stage, found) || explains_none && !standing)
            && let Some(gain) = self.gain(stage, row, found, &|o| {
                o.mode.pressures.iter_mut().for_each(|(_, p)| *p = p.conj());
                let n = o.mode.covariance.rows();
                let first = n - 2 * o.mode.pressures.len();
                turn(&mut o.mode.covariance, |k| k >= first && (k - first) % 2 == 1);
            })?
        {
            said.push(format!(
                "with the complex conjugates of all pressures this model gains {gain:.1} nats: pressures vary as exp(i omega t) here; if they were \
                 measured by exp(-i omega t), turn the signs of their imaginary parts or arguments"
            ));
        }
        Ok(said)
    }

    /// By how much a model gains with the data that `change` makes, nats, where that leads.
    pub(super) fn gain(
        &self,
        stage: &Stage,
        row: &Row,
        found: &Chosen,
        change: &dyn Fn(&mut Observed),
    ) -> Result<Option<f64>, EngineError> {
        self.go_on()?;
        let mut points = found.observed.to_vec();
        points.iter_mut().for_each(change);
        let stands_on = StandsOn::one(found.known.clone(), Arc::new(points));
        let Ok(other) = self.train_row(stage, row, stands_on, Trusted::Laplace) else { return Ok(None) };
        let gain = other.trained.evidence.ln_marginal - found.trained.evidence.ln_marginal;
        Ok(Some(gain).filter(|gain| *gain > LEADS))
    }

    /// True if the imaginary parts that a model predicts are nearer to the measured ones with the other sign.
    fn nearer_conjugated(&self, stage: &Stage, found: &Chosen) -> bool {
        let (microphones, reference) = (self.microphones(stage), self.rig.microphones.reference);
        let used: Vec<Used> = found.observed.iter().map(|o| o.used(&microphones, reference)).collect();
        let (mut as_they_are, mut turned) = (0.0, 0.0);
        for ((k, row), residual) in found.rows(&used).into_iter().zip(&found.trained.linear.0.residuals) {
            if row < 2 || row % 2 == 0 {
                continue;
            }
            let imaginary = used[k].pressures[(row - 2) / 2].im;
            as_they_are += residual * residual;
            turned += (residual - 2.0 * imaginary).powi(2);
        }
        turned < as_they_are
    }
}

/// Standard deviation of numbers about their mean.
fn spread(all: &[f64]) -> f64 {
    let n = all.len().max(1) as f64;
    let mean = all.iter().sum::<f64>() / n;
    (all.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt()
}

/// The covariance of numbers of which some have turned their sign.
fn turn(covariance: &mut Matrix, turned: impl Fn(usize) -> bool) {
    let n = covariance.rows();
    let sign = |i: usize| if turned(i) { -1.0 } else { 1.0 };
    *covariance = Matrix::from_fn(n, n, |i, j| sign(i) * sign(j) * covariance[(i, j)]);
}
