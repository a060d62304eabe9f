//! The result of an assimilation, and what it says of itself.

use super::bounded::Moments;
use super::{Batch, physical};
use crate::number::Dual;
use crate::{BaseState, ErrorComponent, FlowError, Pipe, UNKNOWNS, Unknowns};
use rijke_inference::Parameter;
use rijke_numerics::{Matrix, symmetric_eigen};
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
    /// Mean and covariance of the physical unknowns.
    physical: Vec<f64>,
    physical_covariance: Matrix,
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
        let residual = batch.means.iter().zip(predicted).map(|(m, p)| m - p).collect();
        for white in batch.whitening.apply(residual).chunks(sensors) {
            for j in 0..sensors {
                chi += white[j] * white[j];
                squares[j] += white[j] * white[j];
                lagged[j] += white[j] * last[j];
            }
            last.copy_from_slice(white);
        }
        let data = batch.means.len() as f64;
        let named = |test: &dyn Fn(usize) -> bool| {
            (0..UNKNOWNS).filter(|&i| test(i)).map(|i| batch.priors[i].name.clone()).collect()
        };
        Ok(Self {
            chi_squared: chi / (data - scores.len() as f64),
            chi_squared_sd: (2.0 / data).sqrt(),
            whiteness: lagged.iter().zip(&squares).map(|(l, s)| l / s).collect(),
            bins: batch.means.len() / sensors,
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
    /// From a Gaussian in the scores, to first order in the transforms.
    pub(crate) fn new(
        priors: &[Parameter; UNKNOWNS],
        names: Vec<String>,
        mean: Vec<f64>,
        covariance: Matrix,
        health: Option<Health>,
    ) -> Result<Self, FlowError> {
        let duals: Vec<Dual<1>> = (priors.iter().zip(&mean))
            .map(|(p, &z)| physical(p, Dual::<1>::variable(z, 0)))
            .collect::<Result<_, _>>()?;
        let slope = |i: usize| duals[i].slopes[0];
        let physical_covariance =
            Matrix::from_fn(UNKNOWNS, UNKNOWNS, |i, j| covariance[(i, j)] * slope(i) * slope(j));
        let physical = duals.iter().map(|d| d.value).collect();
        Ok(Self { names, mean, covariance, health, priors: priors.clone(), physical, physical_covariance })
    }

    pub(crate) fn of_moments(
        priors: &[Parameter; UNKNOWNS],
        names: Vec<String>,
        moments: Moments,
        health: Option<Health>,
    ) -> Self {
        let Moments { scores, covariance, physical, physical_covariance } = moments;
        let priors = priors.clone();
        Self { names, mean: scores, covariance, health, priors, physical, physical_covariance }
    }

    /// The unknowns at their posterior mean.
    #[must_use]
    pub fn unknowns(&self) -> Unknowns {
        let mut values = [0.0; UNKNOWNS];
        values.copy_from_slice(&self.physical);
        Unknowns::from_array(values)
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
        let u = self.unknowns();
        let steady = pipe.steady(&u.parameters, power * u.power_factor, ambient + u.ambient_offset)?;
        let mut base = steady.base_state(pipe);
        let sensitivities = steady.sensitivities(pipe)?;
        // In units of the posterior sd, so that no unit hides another; sensitivities to the power are relative.
        let unit: Vec<f64> = (0..8).map(|i| self.physical_covariance[(i, i)].max(0.0).sqrt()).collect();
        let inverse = |i: usize| if unit[i] > 0.0 { 1.0 / unit[i] } else { 0.0 };
        let (values, vectors) = symmetric_eigen(&Matrix::from_fn(8, 8, |i, j| {
            self.physical_covariance[(i, j)] * inverse(i) * inverse(j)
        }))?;
        let slopes: Vec<f64> =
            (0..8).map(|i| if i == 6 { unit[i] / u.power_factor } else { unit[i] }).collect();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Closures;
    use crate::unknowns;
    use rijke_rig::Rig;

    #[test]
    fn oracle_base_state_errors_are_differences_along_the_unknowns() {
        let pipe = Pipe::new(&Rig::juniper_yoko_2022(), &Closures::default(), 0.25, 1).unwrap();
        let names: Vec<String> = unknowns().iter().map(|p| p.name.clone()).collect();
        // Some covariance with correlations.
        let root = Matrix::from_fn(UNKNOWNS, UNKNOWNS, |i, j| 0.1 * ((3 * i + 7 * j + i * j) as f64).sin());
        let covariance = root.product(&root.transpose());
        let mut estimate = Estimate::new(&unknowns(), names, vec![0.2; UNKNOWNS], covariance, None).unwrap();
        let base = estimate.base_state(&pipe, 180.0, 293.0).unwrap();
        // var(U) = g' C g with g by central differences in the first eight unknowns.
        let mut slope = |k: usize| {
            let step = 1e-4 * estimate.physical_covariance[(k, k)].sqrt();
            let mut at = |h: f64| {
                estimate.physical[k] += h;
                let u = estimate.base_state(&pipe, 180.0, 293.0).unwrap().heater_velocity;
                estimate.physical[k] -= h;
                u
            };
            (at(step) - at(-step)) / (2.0 * step)
        };
        let g: Vec<f64> = (0..8).map(&mut slope).collect();
        let variance = estimate.physical_covariance.select(&[0, 1, 2, 3, 4, 5, 6, 7]).quadratic(&g);
        assert!((base.heater_velocity_sd() / variance.sqrt() - 1.0).abs() < 1e-5);
    }
}
