//! Fits of simulated data: does the method recover what it should?

use crate::covariance::Factor;
use crate::error::InferenceError;
use crate::evidence::Laplace;
use crate::fit::{Fit, MapOptions, Posterior};
use crate::numbers::normal_cdf;
use crate::problem::{Data, NoiseMode, Observation};
use rand::RngExt;
use rand_distr::StandardNormal;
use rayon::prelude::*;
use rijke_numerics::{InOrder, Order, Stream, Streams};
use serde::{Deserialize, Serialize};

/// What refits of simulated data say of one parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParameterCheck {
    /// Name.
    pub name: String,
    /// The value that the data were simulated with.
    pub truth: f64,
    /// Mean of (estimate - truth), in the units of the parameter.
    pub bias: f64,
    /// Standard error of that mean.
    pub bias_error: f64,
    /// Standard deviation of the estimates over the data sets.
    pub scatter: f64,
    /// Mean of the posterior standard deviations that the fits state.
    pub stated_sd: f64,
    /// Fraction of data sets in which the truth lies within one stated sd (0.683 is expected).
    pub within_1_sd: f64,
    /// Fraction within two (0.954 is expected).
    pub within_2_sd: f64,
}

/// The outcome of [`Posterior::check`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModelCheck {
    /// One row per parameter.
    pub parameters: Vec<ParameterCheck>,
    /// Data sets simulated.
    pub sets: usize,
    /// Data sets whose fit failed or did not converge; they are left out of the rows.
    pub failed: usize,
}

/// The outcome of [`Posterior::calibrate`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SimulatedCoverage {
    /// Name of each parameter.
    pub names: Vec<String>,
    /// For each parameter, how many truths fell into each of twenty equally probable slices of their
    /// posterior.
    pub histograms: Vec<Vec<usize>>,
    /// For each parameter, the probability of a chi-squared at least as large if the truths are spread
    /// evenly.
    pub p_values: Vec<f64>,
    /// Draws used.
    pub draws: usize,
    /// Draws whose model, fit or Laplace approximation failed.
    pub failed: usize,
}

/// Slices of [`SimulatedCoverage`].
const SLICES: usize = 20;

impl Posterior<'_> {
    /// Data as the model with these working coordinates would give them: prediction plus noise.
    ///
    /// # Errors
    /// Those of the model, [`InferenceError::SingularCovariance`].
    pub fn simulate(&self, working: &[f64], stream: &mut Stream) -> Result<Data, InferenceError> {
        let p = self.parameters().len();
        let predicted = self.predict(&self.parameters().physical(&working[..p]), Order::Value)?.values;
        let sds = self.noise_sd(working);
        let mut observations = Vec::with_capacity(self.data().observations().len());
        let mut first = 0;
        for observation in self.data().observations() {
            let n = observation.values.len();
            let noise = Factor::new(observation, &sds)?.draw(observation, stream);
            let values = (0..n).map(|i| predicted[first + i] + noise[i]).collect();
            observations.push(Observation { values, ..observation.clone() });
            first += n;
        }
        Data::new(observations, self.data().groups().to_vec())
    }

    /// Simulates `sets` data sets with the parameters and noise of `fit`, refits each from the centre of the
    /// prior, and compares: a test of method and model together. A prior pulls the estimates towards its
    /// mean, which shows as bias.
    ///
    /// # Errors
    /// Errors that are not recoverable.
    pub fn check(
        &self,
        fit: &Fit,
        options: &MapOptions,
        sets: usize,
        streams: Streams,
    ) -> Result<ModelCheck, InferenceError> {
        let refits: Vec<Option<Laplace>> = (0..sets)
            .into_par_iter()
            .map(|k| {
                let mut stream = streams.stream(&format!("inference/check/{k}"));
                self.refit(&fit.working, options, &mut stream)
            })
            .in_order::<Result<_, _>>()?;
        let good: Vec<Laplace> = refits.into_iter().flatten().collect();
        let count = good.len() as f64;
        let rows = self.parameters().list().iter().enumerate().map(|(i, parameter)| {
            let truth = fit.parameters[i];
            let misses: Vec<f64> = good.iter().map(|l| l.parameters[i] - truth).collect();
            let sds: Vec<f64> = good.iter().map(|l| l.sd()[i]).collect();
            let bias = misses.iter().sum::<f64>() / count;
            let scatter =
                (misses.iter().map(|m| (m - bias).powi(2)).sum::<f64>() / (count - 1.0).max(1.0)).sqrt();
            let within =
                |n: f64| misses.iter().zip(&sds).filter(|(m, s)| m.abs() <= n * **s).count() as f64 / count;
            ParameterCheck {
                name: parameter.name.clone(),
                truth,
                bias,
                bias_error: scatter / count.sqrt(),
                scatter,
                stated_sd: sds.iter().sum::<f64>() / count,
                within_1_sd: within(1.0),
                within_2_sd: within(2.0),
            }
        });
        let parameters = rows.collect();
        Ok(ModelCheck { parameters, sets, failed: sets - good.len() })
    }

    /// Simulation-based calibration (Talts et al. 2018): truths drawn from the prior must be spread evenly
    /// over the quantiles of their posteriors. Laplace's Gaussian stands for the posterior, so ranks are its
    /// quantiles.
    ///
    /// Noise: inferred groups are drawn from their priors; floated groups are simulated with the sd in `fit`.
    ///
    /// # Errors
    /// [`InferenceError::Improper`], and errors that are not recoverable.
    pub fn calibrate(
        &self,
        fit: &Fit,
        options: &MapOptions,
        draws: usize,
        streams: Streams,
    ) -> Result<SimulatedCoverage, InferenceError> {
        if let Some(parameter) = self.parameters().improper() {
            return Err(InferenceError::Improper { parameter: parameter.name.clone() });
        }
        let p = self.parameters().len();
        let quantiles: Vec<Option<Vec<f64>>> = (0..draws)
            .into_par_iter()
            .map(|k| {
                let mut stream = streams.stream(&format!("inference/calibrate/{k}"));
                let xi: Vec<f64> = (0..p).map(|_| stream.sample(StandardNormal)).collect();
                let mut truth = fit.working.clone();
                truth[..p].copy_from_slice(&self.parameters().from_standard_normal(&xi));
                for (i, &g) in self.floating().iter().enumerate() {
                    if let NoiseMode::Inferred { median, ln_sd } = self.data().groups()[g].mode {
                        truth[p + i] = median.ln() + ln_sd * stream.sample::<f64, _>(StandardNormal);
                    }
                }
                let refit = self.refit(&truth, options, &mut stream)?;
                Ok(refit.map(|l| {
                    (0..p).map(|i| normal_cdf((truth[i] - l.mean[i]) / l.covariance[(i, i)].sqrt())).collect()
                }))
            })
            .in_order::<Result<_, InferenceError>>()?;
        let good: Vec<Vec<f64>> = quantiles.into_iter().flatten().collect();
        let histograms: Vec<Vec<usize>> = (0..p)
            .map(|i| {
                let mut slices = vec![0; SLICES];
                for quantile in &good {
                    slices[((quantile[i] * SLICES as f64) as usize).min(SLICES - 1)] += 1;
                }
                slices
            })
            .collect();
        Ok(SimulatedCoverage {
            names: self.parameters().list().iter().map(|q| q.name.clone()).collect(),
            p_values: histograms.iter().map(|h| even_probability(h)).collect(),
            histograms,
            draws,
            failed: draws - good.len(),
        })
    }

    /// Simulates and fits once; nothing if model, fit or Laplace's method failed in a way that another draw
    /// may not.
    fn refit(
        &self,
        truth: &[f64],
        options: &MapOptions,
        stream: &mut Stream,
    ) -> Result<Option<Laplace>, InferenceError> {
        let survived = |error: InferenceError| match &error {
            InferenceError::NoStart { source, .. } if source.is_recoverable() => Ok(None),
            InferenceError::NoLaplace { .. } => Ok(None),
            other if other.is_recoverable() => Ok(None),
            _ => Err(error),
        };
        let data = match self.simulate(truth, stream) {
            Ok(data) => data,
            Err(error) => return survived(error),
        };
        let again = Posterior::new(self.forward(), &data, self.parameters())?;
        let fit = match again.map(options) {
            Ok(fit) if fit.stop.converged() => fit,
            Ok(_) => return Ok(None),
            Err(error) => return survived(error),
        };
        again.laplace(&fit).map(Some).or_else(survived)
    }
}

/// Probability that evenly spread counts have a chi-squared at least as large as these have; Wilson &
/// Hilferty's normal approximation, good to 0.001 for nineteen degrees of freedom.
fn even_probability(counts: &[usize]) -> f64 {
    let expected = counts.iter().sum::<usize>() as f64 / counts.len() as f64;
    let chi_squared: f64 = counts.iter().map(|&c| (c as f64 - expected).powi(2) / expected).sum();
    let freedom = counts.len() as f64 - 1.0;
    let spread = 2.0 / (9.0 * freedom);
    normal_cdf(-((chi_squared / freedom).cbrt() - (1.0 - spread)) / spread.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oracle_chi_squared_table() {
        // 19 degrees of freedom: 30.144 is exceeded with probability 0.05 (Abramowitz & Stegun, table 26.8).
        let mut counts = vec![10_000; 20];
        let shift = (30.144_f64 * 10_000.0 / 2.0).sqrt() as usize;
        counts[0] += shift;
        counts[1] -= shift;
        assert!((even_probability(&counts) - 0.05).abs() < 0.001);
        assert!(even_probability(&[50; 20]) > 0.99);
    }
}
