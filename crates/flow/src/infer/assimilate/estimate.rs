//! The result of an assimilation: what is known of the unknowns, and the base states that follow.

use crate::base::state::{BaseState, ErrorComponent};
use crate::error::FlowError;
use crate::infer::health::FlowHealth;
use crate::infer::scores::physical;
use crate::tube::parameters::{UNKNOWNS, Unknowns};
use crate::tube::pipe::Pipe;
use rand::RngExt;
use rand_distr::StandardNormal;
use rijke_inference::Parameter;
use rijke_numerics::{Matrix, Streams, principal_directions, symmetric_eigen};

/// What is known of the scores: unknowns first, then constant errors of sensors in units of their own sd.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// Names of the scores.
    pub names: Vec<String>,
    /// Mean of the scores.
    pub mean: Vec<f64>,
    /// Covariance of the scores.
    pub covariance: Matrix,
    /// What the method says of its own result; none for a method that cannot tell.
    pub health: Option<FlowHealth>,
    /// Draws that know the mean as well as independent ones; none for a method whose posterior is taken as
    /// Gaussian.
    pub effective_draws: Option<f64>,
    priors: [Parameter; UNKNOWNS],
    /// Equally likely draws of the physical unknowns.
    draws: Vec<[f64; UNKNOWNS]>,
}

/// Draws kept for base states: their sd are then known to 4 %.
const KEPT: usize = 300;
/// Share of the variance of relative changes that the causes of a base state carry.
const CARRIED: f64 = 0.9999;

/// Draws of all scores, each with its weight.
#[derive(Clone, Debug)]
pub(crate) struct Draws {
    /// Scores: those with axes, then constant errors.
    pub(crate) scores: Vec<Vec<f64>>,
    /// Weights, which sum to 1.
    pub(crate) weights: Vec<f64>,
}

impl Draws {
    /// Number of independent draws that know the mean as well: 1/(sum of squared weights).
    pub(crate) fn effective(&self) -> f64 {
        1.0 / self.weights.iter().map(|w| w * w).sum::<f64>()
    }
}

impl Estimate {
    /// From a Gaussian in the scores.
    pub(crate) fn new(
        priors: &[Parameter; UNKNOWNS],
        names: Vec<String>,
        mean: Vec<f64>,
        covariance: Matrix,
    ) -> Result<Self, FlowError> {
        let (values, vectors) = symmetric_eigen(&covariance)?;
        let mut stream = Streams::new(0).stream("flow/estimate/gaussian");
        let draws: Result<_, FlowError> = (0..KEPT)
            .map(|_| {
                let mut scores = mean.clone();
                for (k, value) in values.iter().enumerate() {
                    let white: f64 = stream.sample(StandardNormal);
                    let size = white * value.max(0.0).sqrt();
                    scores.iter_mut().enumerate().for_each(|(i, z)| *z += size * vectors[(i, k)]);
                }
                values_at(priors, &scores)
            })
            .collect();
        let priors = priors.clone();
        Ok(Self { names, mean, covariance, health: None, effective_draws: None, priors, draws: draws? })
    }

    /// From weighted draws.
    pub(crate) fn of_draws(
        priors: &[Parameter; UNKNOWNS],
        names: Vec<String>,
        drawn: &Draws,
    ) -> Result<Self, FlowError> {
        let weighted = || drawn.scores.iter().zip(&drawn.weights);
        let size = names.len();
        let mean: Vec<f64> = (0..size).map(|i| weighted().map(|(z, w)| w * z[i]).sum()).collect();
        let effective = drawn.effective();
        let correction = 1.0 / (1.0 - 1.0 / effective);
        let covariance = Matrix::from_fn(size, size, |i, j| {
            correction * weighted().map(|(z, w)| w * (z[i] - mean[i]) * (z[j] - mean[j])).sum::<f64>()
        });
        // Systematic resampling from the middle of each share.
        let (mut draws, mut sum, mut next) = (Vec::with_capacity(KEPT), 0.0, 0.5 / KEPT as f64);
        for (scores, weight) in weighted() {
            sum += weight;
            while next < sum && draws.len() < KEPT {
                draws.push(values_at(priors, scores)?);
                next += 1.0 / KEPT as f64;
            }
        }
        let (priors, effective_draws) = (priors.clone(), Some(effective));
        Ok(Self { names, mean, covariance, health: None, effective_draws, priors, draws })
    }

    /// The unknowns at their posterior mean.
    #[must_use]
    pub fn unknowns(&self) -> Unknowns {
        let mut values = [0.0; UNKNOWNS];
        for (i, value) in values.iter_mut().enumerate() {
            *value = self.draws.iter().map(|d| d[i]).sum::<f64>() / self.draws.len() as f64;
        }
        Unknowns::from_array(values)
    }

    /// Physical value of an unknown `sds` standard deviations of its score from the mean: an interval for -2
    /// and 2.
    ///
    /// # Errors
    /// [`FlowError::Prior`].
    pub fn value(&self, unknown: usize, sds: f64) -> Result<f64, FlowError> {
        let z = self.mean[unknown] + sds * self.covariance[(unknown, unknown)].max(0.0).sqrt();
        physical(&self.priors[unknown], z)
    }

    /// Share of the draws of an unknown that lie below `value` (physical): the rank of a truth, for tests of
    /// calibration.
    #[must_use]
    pub fn rank(&self, unknown: usize, value: f64) -> f64 {
        let below = self.draws.iter().filter(|d| d[unknown] < value).count();
        (below as f64 + 0.5) / (self.draws.len() as f64 + 1.0)
    }

    /// The steady base states at several indicated powers (W) and ambient temperatures (K): mean and
    /// principal directions of the steady states of the draws. Components with the same cause are one random
    /// number in all of them.
    ///
    /// # Errors
    /// Those of [`Pipe::steady`].
    pub fn base_states(&self, pipe: &Pipe, conditions: &[(f64, f64)]) -> Result<Vec<BaseState>, FlowError> {
        let u = self.unknowns();
        let at_mean = |&(power, ambient): &(f64, f64)| {
            pipe.steady(&u.parameters, power * u.power_factor, ambient + u.ambient_offset)
        };
        let near = conditions.iter().map(at_mean).collect::<Result<Vec<_>, _>>()?;
        let mut rows = Vec::with_capacity(self.draws.len());
        for draw in &self.draws {
            let u = Unknowns::from_array(*draw);
            let mut row = Vec::new();
            for (&(power, ambient), near) in conditions.iter().zip(&near) {
                let (power, ambient) = (power * u.power_factor, ambient + u.ambient_offset);
                let state = pipe.steady_near(&u.parameters, power, ambient, near)?.base_state(pipe);
                row.extend([state.mass_flux, state.heater_velocity]);
                row.extend(state.temperature);
            }
            rows.push(row);
        }
        let (mean, causes) = principal(rows)?;
        let length = mean.len() / conditions.len().max(1);
        let own = |all: &[f64], k: usize| all[k * length..(k + 1) * length].to_vec();
        let states = near.iter().enumerate().map(|(k, near)| {
            let (at, template) = (own(&mean, k), near.base_state(pipe));
            let errors = causes.iter().enumerate().map(|(n, cause)| {
                let change = own(cause, k);
                ErrorComponent {
                    cause: format!("base flow {}", n + 1),
                    mass_flux: change[0],
                    heater_velocity: change[1],
                    temperature: change[2..].to_vec(),
                }
            });
            BaseState {
                mass_flux: at[0],
                heater_velocity: at[1],
                temperature: at[2..].to_vec(),
                errors: errors.collect(),
                ..template
            }
            .checked()
        });
        states.collect()
    }

    /// One steady base state ([`Estimate::base_states`]).
    ///
    /// # Errors
    /// Those of [`Pipe::steady`].
    pub fn base_state(&self, pipe: &Pipe, power: f64, ambient: f64) -> Result<BaseState, FlowError> {
        let mut states = self.base_states(pipe, &[(power, ambient)])?;
        Ok(states.remove(0))
    }
}

fn values_at(priors: &[Parameter; UNKNOWNS], scores: &[f64]) -> Result<[f64; UNKNOWNS], FlowError> {
    let mut values = [0.0; UNKNOWNS];
    for (value, (parameter, &z)) in values.iter_mut().zip(priors.iter().zip(scores)) {
        *value = physical(parameter, z)?;
    }
    Ok(values)
}

/// Mean of the rows, and the directions in which they scatter, each one sd long, largest first by relative
/// change.
fn principal(mut rows: Vec<Vec<f64>>) -> Result<(Vec<f64>, Vec<Vec<f64>>), FlowError> {
    let count = rows.len();
    let size = rows.first().map_or(0, Vec::len);
    let mean: Vec<f64> = (0..size).map(|j| rows.iter().map(|r| r[j]).sum::<f64>() / count as f64).collect();
    for row in &mut rows {
        row.iter_mut().zip(&mean).for_each(|(r, m)| *r -= m);
    }
    // Still gas has no scale of its own.
    let weight: Vec<f64> = mean.iter().map(|m| if *m == 0.0 { 0.0 } else { m.powi(-2) }).collect();
    let freedom = (count - 1) as f64;
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).zip(&weight).map(|((x, y), w)| x * y * w).sum::<f64>();
    let gram =
        Matrix::from_fn(count, count, |i, j| if j <= i { dot(&rows[i], &rows[j]) / freedom } else { 0.0 });
    let gram = Matrix::from_fn(count, count, |i, j| gram[(i.max(j), i.min(j))]);
    let directions = principal_directions(&gram)?;
    let total: f64 = directions.iter().map(|(value, _)| value).sum();
    let (mut carried, mut causes) = (0.0, Vec::new());
    for (value, along) in directions {
        if value <= 0.0 || carried > CARRIED * total {
            break;
        }
        carried += value;
        let entry =
            |j: usize| along.iter().zip(&rows).map(|(a, row)| a * row[j]).sum::<f64>() / freedom.sqrt();
        causes.push((0..size).map(entry).collect());
    }
    Ok((mean, causes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TubeRig;
    use crate::tube::closures::Closures;
    use crate::tube::parameters::unknowns;

    #[test]
    fn exact_intervals_are_images_of_those_of_the_scores() {
        let half = Matrix::from_fn(UNKNOWNS, UNKNOWNS, |i, j| if i == j { 0.25 } else { 0.0 });
        let estimate = Estimate::new(&unknowns(), Vec::new(), vec![0.0; UNKNOWNS], half).unwrap();
        let value = |unknown: usize, sds: f64| estimate.value(unknown, sds).unwrap();
        // C_d is uniform from 3 to 20, and Phi(1) = 0.8413447461; factors of the power are normal, 1 +- 0.01.
        assert!((value(0, 2.0) - (3.0 + 17.0 * 0.841_344_746_1)).abs() < 1e-8);
        assert!((value(6, -2.0) - 0.99).abs() < 1e-14 && (value(6, 1.0) - 1.005).abs() < 1e-14);
    }

    #[test]
    fn oracle_base_state_errors_are_derivatives_along_the_unknowns() {
        let pipe = Pipe::new(&TubeRig::juniper_yoko_2022(), &Closures::default(), 0.25, 1).unwrap();
        let names: Vec<String> = unknowns().iter().map(|p| p.name.clone()).collect();
        // Some small covariance with correlations.
        let root = Matrix::from_fn(UNKNOWNS, UNKNOWNS, |i, j| 2e-3 * ((3 * i + 7 * j + i * j) as f64).sin());
        let covariance = root.product(&root.transpose());
        let estimate = Estimate::new(&unknowns(), names, vec![0.2; UNKNOWNS], covariance).unwrap();
        let powers = [(30.0, 293.0), (180.0, 293.0)];
        let states = estimate.base_states(&pipe, &powers).unwrap();
        // Scatter of g'u over the draws, with g from the implicit function theorem.
        let u = estimate.unknowns();
        for ((power, ambient), base) in powers.into_iter().zip(states) {
            let steady =
                pipe.steady(&u.parameters, power * u.power_factor, ambient + u.ambient_offset).unwrap();
            let slopes: Vec<f64> =
                steady.sensitivities(&pipe).unwrap().iter().map(|s| s.heater_velocity).collect();
            let centre = u.values();
            let moved = |d: &[f64; UNKNOWNS]| -> f64 {
                (0..8)
                    .map(|i| {
                        let unit = if i == 6 { centre[6] } else { 1.0 };
                        slopes[i] * (d[i] - centre[i]) / unit
                    })
                    .sum()
            };
            let variance = estimate.draws.iter().map(|d| moved(d).powi(2)).sum::<f64>() / (KEPT - 1) as f64;
            let ratio = base.heater_velocity_sd() / variance.sqrt();
            assert!((ratio - 1.0).abs() < 1e-2, "{power} W: {ratio}");
        }
    }
}
