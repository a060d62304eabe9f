//! All clicks at once: the most probable unknowns, and the posterior around them.

use super::bounded::moments;
use super::estimate::{Estimate, Health};
use super::record::observe;
use super::whitening::Whitening;
use super::{Record, smooth_ambient, unknowns_from};
use crate::number::{Dual, Number};
use crate::{FlowError, Pipe, Transient, UNKNOWNS, unknowns};
use rijke_inference::{
    Data, Forward, ForwardError, MapOptions, Observation, Parameter, Parameters, Posterior, Prediction, Prior,
};
use rijke_numerics::{Matrix, Order, Streams};

/// A record with a pipe, ready to be fitted.
///
/// Readings are averaged over `bin` samples, and so are the predictions: averaging the data but predicting one instant
/// would spoil the transients. The unknowns are the ten of [`unknowns`] and one constant error per biased sensor.
#[derive(Clone, Debug)]
pub struct Batch<'a> {
    pub(crate) pipe: &'a Pipe,
    pub(crate) record: &'a Record,
    pub(crate) priors: [Parameter; UNKNOWNS],
    pub(crate) ambient: Vec<f64>,
    pub(crate) bin: usize,
    /// Mean reading of every sensor in every bin, one bin after the other.
    pub(crate) means: Vec<f64>,
    pub(crate) whitening: Whitening,
}

impl<'a> Batch<'a> {
    /// Averages over `bin` samples (10 is a good choice); `record` must have been [`Record::checked`].
    #[must_use]
    pub fn new(pipe: &'a Pipe, record: &'a Record, bin: usize) -> Self {
        let bin = bin.max(1);
        let ambient = smooth_ambient(record);
        let mut means = Vec::new();
        for samples in record.samples.chunks(bin) {
            let mean = |j: usize| samples.iter().map(|s| s.readings[j]).sum::<f64>() / samples.len() as f64;
            means.extend((0..record.sensors.len()).map(mean));
        }
        let whitening = Whitening::new(pipe, record, &ambient, bin);
        Self { pipe, record, priors: unknowns(), ambient: ambient.temperature, bin, means, whitening }
    }

    /// The same with other priors on the ten unknowns.
    #[must_use]
    pub fn with_priors(self, priors: [Parameter; UNKNOWNS]) -> Self {
        Self { priors, ..self }
    }

    /// Number of scores: unknowns, then constant errors.
    #[must_use]
    pub fn scores(&self) -> usize {
        UNKNOWNS + self.record.biased().count()
    }

    /// Mean predicted reading of every sensor in every bin, one bin after the other.
    pub(crate) fn run<N: Number>(&self, scores: &[N]) -> Result<Vec<N>, FlowError> {
        let unknowns = unknowns_from(&self.priors, scores)?;
        let record = self.record;
        let implicit = self.pipe.implicit(record.interval);
        let mut state = Transient::cold(self.pipe, &unknowns, self.ambient[0])?;
        let (mut times, mut seen) = (Vec::new(), Vec::new());
        let mut out = Vec::with_capacity(self.means.len());
        let indexed: Vec<_> = record.samples.iter().zip(&self.ambient).collect();
        for samples in indexed.chunks(self.bin) {
            let mut sums = vec![N::constant(0.0); record.sensors.len()];
            for (sample, ambient) in samples {
                state.step(self.pipe, &implicit, &unknowns, sample.power, **ambient, TOLERANCE)?;
                observe(self.pipe, &record.sensors, &state.gas, &unknowns, &mut times, &mut seen);
                sums.iter_mut().zip(&seen).for_each(|(sum, &s)| *sum = *sum + s);
            }
            for (k, (bias, sd)) in record.biased().enumerate() {
                sums[bias] = sums[bias] + scores[UNKNOWNS + k] * (sd * samples.len() as f64);
            }
            out.extend(sums.into_iter().map(|sum| sum * (1.0 / samples.len() as f64)));
        }
        Ok(out)
    }

    /// The mean scores and their covariance: the most probable scores first, then the posterior of the model linearised
    /// there, with the bounds of the priors kept exactly. The draws that this takes are the same in every run.
    ///
    /// # Errors
    /// [`FlowError::Inference`] with the words of the minimiser.
    pub fn fit(&self) -> Result<Estimate, FlowError> {
        let words = |e: rijke_inference::InferenceError| FlowError::Inference(e.to_string());
        let prior = Prior::Normal { mean: 0.0, sd: 1.0 };
        let score = |name: String| Parameter::new(&name, &name, "1", prior);
        let mut names: Vec<String> = self.priors.iter().map(|p| p.name.clone()).collect();
        names.extend(self.record.biased().map(|(i, _)| format!("bias_{i}")));
        let parameters = Parameters::new(names.iter().cloned().map(score).collect()).map_err(words)?;
        let sensors = self.record.sensors.len();
        let unit = Matrix::identity(sensors);
        let white = self.whitening.apply(self.means.clone());
        let observations = white.chunks(sensors).enumerate().map(|(k, values)| {
            Observation::new(format!("bin {k}"), values.to_vec()).with_floor(unit.clone())
        });
        let data = Data::new(observations.collect(), Vec::new()).map_err(words)?;
        let posterior = Posterior::new(self, &data, &parameters).map_err(words)?;
        let fit = posterior.map(&MapOptions::default()).map_err(words)?;
        let laplace = posterior.laplace(&fit).map_err(words)?;
        let predicted = self.run(&fit.working)?;
        let health = Health::new(self, &fit.working, &laplace.covariance, &predicted, fit.stop.converged())?;
        let slopes = Forward::predict(self, &fit.working, Order::First)
            .map_err(|e| FlowError::Inference(e.to_string()))?
            .jacobian;
        let residual = self.means.iter().zip(&predicted).map(|(m, p)| m - p).collect();
        let moments = moments(
            &self.priors,
            &fit.working,
            &self.whitening.apply(residual),
            &slopes,
            &mut Streams::new(0).stream("flow/batch/bounded"),
        )?;
        Ok(Estimate::of_moments(&self.priors, names, moments, Some(health)))
    }
}

/// Tolerance of the mass flow: 1e-9 in U_h, so that the derivatives of the fit are exact.
const TOLERANCE: f64 = 1e-10;

impl Forward for Batch<'_> {
    fn predict(&self, scores: &[f64], order: Order) -> Result<Prediction, ForwardError> {
        if order == Order::Value {
            let values = self.whitening.apply(self.run(scores).map_err(ForwardError::recoverable)?);
            return Ok(Prediction { values, jacobian: Matrix::zeros(0, 0), curvature: Vec::new() });
        }
        // The constant errors act linearly; their columns need no derivatives.
        const P: usize = UNKNOWNS + 1;
        let seeds: Vec<Dual<P>> = scores
            .iter()
            .enumerate()
            .map(|(i, &z)| if i < UNKNOWNS { Dual::variable(z, i) } else { Dual::constant(z) })
            .collect();
        let predicted = self.run(&seeds).map_err(ForwardError::recoverable)?;
        let biased: Vec<(usize, f64)> = self.record.biased().collect();
        let sensors = self.record.sensors.len();
        let column = |i: usize| -> Vec<f64> {
            let slope = |k: usize| match i.checked_sub(UNKNOWNS) {
                None => predicted[k].slopes[i],
                Some(bias) if k % sensors == biased[bias].0 => biased[bias].1,
                Some(_) => 0.0,
            };
            self.whitening.apply((0..predicted.len()).map(slope).collect())
        };
        let columns: Vec<Vec<f64>> = (0..scores.len()).map(column).collect();
        let jacobian = Matrix::from_fn(predicted.len(), scores.len(), |k, i| columns[i][k]);
        let values = self.whitening.apply(predicted.iter().map(|p| p.value).collect());
        Ok(Prediction { values, jacobian, curvature: Vec::new() })
    }

    fn highest_order(&self) -> Order {
        Order::First
    }
}
