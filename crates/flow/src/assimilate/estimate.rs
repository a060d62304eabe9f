//! The result of an assimilation, and what it says of itself.

use super::{Batch, physical};
use crate::number::Dual;
use crate::{BaseState, ErrorComponent, FlowError, Pipe, UNKNOWNS, Unknowns};
use rijke_inference::Parameter;
use rijke_numerics::{Cholesky, Matrix, symmetric_eigen};
use serde::{Deserialize, Serialize};

/// Gaussian in the scores: unknowns first, then constant errors of sensors in units of their own sd.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// Names of the scores.
    pub names: Vec<String>,
    /// Mean of the scores.
    pub mean: Vec<f64>,
    /// Covariance of the scores.
    pub covariance: Matrix,
    /// What the method says of its own result; none for a method that cannot tell.
    pub health: Option<Health>,
    priors: [Parameter; UNKNOWNS],
}

/// Signs of trouble. None of them proves health: model error can hide in parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Health {
    /// Chi-squared of the residuals per datum (data minus unknowns); 1 is expected.
    pub chi_squared: f64,
    /// Its sd if the model is right.
    pub chi_squared_sd: f64,
    /// Correlation of each sensor's residual with its neighbour in time; 0 is expected.
    pub whiteness: Vec<f64>,
    /// Number of residuals per sensor: the sd of the whiteness is 1/sqrt of it.
    pub bins: usize,
    /// Names of unknowns whose posterior sd exceeds 0.7 of the prior sd: the data do not identify them.
    pub unidentified: Vec<String>,
    /// Names of unknowns further than 2.5 prior sd from the centre: the prior bounds them, not the data.
    pub at_bound: Vec<String>,
    /// Whether the minimiser converged.
    pub converged: bool,
}

/// One reason not to trust an estimate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "warning", rename_all = "snake_case")]
pub enum Warning {
    /// The residuals are larger than the noise.
    PoorFit {
        /// Chi-squared per datum.
        chi_squared: f64,
    },
    /// The residuals of a sensor follow a pattern in time.
    Pattern {
        /// Number of the sensor.
        sensor: usize,
        /// Correlation of neighbours.
        correlation: f64,
    },
    /// An unknown is held by its prior's bound.
    AtBound {
        /// Its name.
        name: String,
    },
    /// The minimiser gave up.
    NotConverged,
}

impl Health {
    pub(crate) fn new(
        batch: &Batch<'_>,
        scores: &[f64],
        covariance: &Matrix,
        predicted: &[f64],
        converged: bool,
    ) -> Result<Self, FlowError> {
        let sensors = batch.record.sensors.len();
        let (mut chi, mut lagged, mut squares) = (0.0, vec![0.0; sensors], vec![0.0; sensors]);
        let mut last = vec![0.0; sensors];
        for (k, (mean, c)) in batch.means.iter().zip(&batch.covariances).enumerate() {
            let residual: Vec<f64> = mean.iter().zip(&predicted[k * sensors..]).map(|(m, p)| m - p).collect();
            let white = Cholesky::new(c)?.whiten(&residual);
            for j in 0..sensors {
                chi += white[j] * white[j];
                squares[j] += white[j] * white[j];
                lagged[j] += white[j] * last[j];
            }
            last = white;
        }
        let data = (batch.means.len() * sensors) as f64;
        let named = |test: &dyn Fn(usize) -> bool| {
            (0..UNKNOWNS).filter(|&i| test(i)).map(|i| batch.priors[i].name.clone()).collect()
        };
        Ok(Self {
            chi_squared: chi / (data - scores.len() as f64),
            chi_squared_sd: (2.0 / data).sqrt(),
            whiteness: lagged.iter().zip(&squares).map(|(l, s)| l / s).collect(),
            bins: batch.means.len(),
            unidentified: named(&|i| covariance[(i, i)].sqrt() > 0.7),
            at_bound: named(&|i| scores[i].abs() > 2.5),
            converged,
        })
    }

    /// Reasons not to trust the estimate: a chi-squared or a correlation more than four sd from what is expected, a
    /// bound, a search that gave up.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        let mut list = Vec::new();
        if !self.converged {
            list.push(Warning::NotConverged);
        }
        if self.chi_squared > 1.0 + 4.0 * self.chi_squared_sd {
            list.push(Warning::PoorFit { chi_squared: self.chi_squared });
        }
        let limit = 4.0 / (self.bins as f64).sqrt();
        for (sensor, &correlation) in self.whiteness.iter().enumerate() {
            if correlation.abs() > limit {
                list.push(Warning::Pattern { sensor, correlation });
            }
        }
        list.extend(self.at_bound.iter().map(|name| Warning::AtBound { name: name.clone() }));
        list
    }
}

impl Estimate {
    pub(crate) fn new(
        priors: &[Parameter; UNKNOWNS],
        names: Vec<String>,
        mean: Vec<f64>,
        covariance: Matrix,
        health: Option<Health>,
    ) -> Result<Self, FlowError> {
        Ok(Self { names, mean, covariance, health, priors: priors.clone() })
    }

    /// The unknowns at the mean score.
    ///
    /// # Errors
    /// [`FlowError::Prior`].
    pub fn unknowns(&self) -> Result<Unknowns, FlowError> {
        super::unknowns_from(&self.priors, &self.mean)
    }

    /// Physical value of an unknown `sds` standard deviations of its score from the mean: an interval for -2 and 2.
    ///
    /// # Errors
    /// [`FlowError::Prior`].
    pub fn value(&self, unknown: usize, sds: f64) -> Result<f64, FlowError> {
        let z = self.mean[unknown] + sds * self.covariance[(unknown, unknown)].max(0.0).sqrt();
        physical(&self.priors[unknown], z)
    }

    /// The steady base state at indicated `power` (W) and `ambient` (K), with one error component per independent
    /// direction of the scores' covariance that moves it.
    ///
    /// # Errors
    /// Those of [`Pipe::steady`].
    pub fn base_state(&self, pipe: &Pipe, power: f64, ambient: f64) -> Result<BaseState, FlowError> {
        let u = self.unknowns()?;
        let steady = pipe.steady(&u.parameters, power * u.power_factor, ambient + u.ambient_offset)?;
        let mut base = steady.base_state(pipe);
        let sensitivities = steady.sensitivities(pipe)?;
        let (values, vectors) = symmetric_eigen(&self.covariance.select(&(0..8).collect::<Vec<_>>()))?;
        // Slope of each physical value along its score; the power factor acts relative to the true power.
        let mut slopes = [0.0; 8];
        for (i, slope) in slopes.iter_mut().enumerate() {
            *slope = physical(&self.priors[i], Dual::<1>::variable(self.mean[i], 0))?.slopes[0];
        }
        slopes[6] /= u.power_factor;
        for (k, value) in values.iter().enumerate().rev() {
            let size = value.max(0.0).sqrt();
            let weight = |i: usize| size * vectors[(i, k)] * slopes[i];
            let mut error = ErrorComponent {
                cause: format!("base flow {}", base.errors.len() + 1),
                mass_flux: 0.0,
                heater_velocity: 0.0,
                temperature: vec![0.0; base.places.len()],
            };
            for (i, s) in sensitivities.iter().enumerate() {
                error.mass_flux += weight(i) * s.mass_flow / pipe.area;
                error.heater_velocity += weight(i) * s.heater_velocity;
                error.temperature.iter_mut().zip(&s.temperature).for_each(|(t, d)| *t += weight(i) * d);
            }
            base.errors.push(error);
        }
        Ok(base)
    }
}
