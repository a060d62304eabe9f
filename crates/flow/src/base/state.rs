//! The base state of one operating point: what acoustics needs to know of the slow flow.

use crate::error::FlowError;
use rijke_numerics::{Matrix, interpolate};
use rijke_rig::{Gas, GasState};
use serde::{Deserialize, Serialize};

/// Gas temperature along the tube and velocity at the heater, with their uncertainty.
///
/// The temperature is linear between the nodes of the profile; density and sound speed follow from the gas at
/// the ambient pressure (the flow's own pressure differences are below 10 Pa). The uncertainty is a list of
/// [`ErrorComponent`]s: the state is mean + sum over k of z_k times component k, with z_k independent and
/// standard normal. An exactly known state has none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BaseState {
    /// The gas in the tube.
    pub gas: Gas,
    /// Ambient pressure, Pa.
    pub pressure: f64,
    /// Mass flux, kg/(m^2 s), positive upward; uniform along the tube once the flow is steady.
    pub mass_flux: f64,
    /// Velocity of the gas that approaches the heater, U_h, m/s; zero without a heater or without power.
    pub heater_velocity: f64,
    /// Places of the profile, m, ascending; the first and last are the ends of the tube.
    pub places: Vec<f64>,
    /// Gas temperature at the places, K.
    pub temperature: Vec<f64>,
    /// Independent contributions to the error.
    pub errors: Vec<ErrorComponent>,
}

/// One standard deviation of one independent cause of error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ErrorComponent {
    /// What the error comes from, for instance `"ambient temperature"` or `"posterior 3"`.
    pub cause: String,
    /// Change of the mass flux, kg/(m^2 s).
    pub mass_flux: f64,
    /// Change of the velocity at the heater, m/s.
    pub heater_velocity: f64,
    /// Change of the temperature at the places of the profile, K.
    pub temperature: Vec<f64>,
}

impl BaseState {
    /// Gas at rest at one temperature (K), as without power: exact, with the sd of the temperature as the
    /// only error (0 for none).
    ///
    /// # Errors
    /// [`FlowError::Temperature`] or [`FlowError::Profile`] for a value that is not positive,
    /// [`FlowError::Setting`] for a standard deviation that is negative or not finite.
    pub fn uniform(
        gas: &Gas,
        pressure: f64,
        length: f64,
        temperature: f64,
        temperature_sd: f64,
    ) -> Result<Self, FlowError> {
        if !(temperature_sd >= 0.0 && temperature_sd.is_finite()) {
            let (name, must) = ("temperature_sd", "zero or more, in kelvin, and finite");
            return Err(FlowError::Setting { name, value: temperature_sd, must });
        }
        let errors = if temperature_sd > 0.0 {
            vec![ErrorComponent {
                cause: "ambient temperature".into(),
                mass_flux: 0.0,
                heater_velocity: 0.0,
                temperature: vec![temperature_sd; 2],
            }]
        } else {
            Vec::new()
        };
        let state = Self {
            gas: gas.clone(),
            pressure,
            mass_flux: 0.0,
            heater_velocity: 0.0,
            places: vec![0.0, length],
            temperature: vec![temperature; 2],
            errors,
        };
        state.checked()
    }

    /// The same state if it is sound.
    ///
    /// # Errors
    /// [`FlowError::Temperature`] for a temperature that is not positive, [`FlowError::Profile`] for places
    /// that do not ascend, lists of different length, or a pressure that is not positive.
    pub fn checked(self) -> Result<Self, FlowError> {
        if let Some((i, &t)) =
            self.temperature.iter().enumerate().find(|(_, t)| !(**t > 0.0 && t.is_finite()))
        {
            return Err(FlowError::Temperature {
                x: self.places.get(i).copied().unwrap_or(f64::NAN),
                kelvin: t,
            });
        }
        let nodes = self.places.len();
        let ascending = self.places.windows(2).all(|w| w[0] < w[1]);
        let lengths =
            self.temperature.len() == nodes && self.errors.iter().all(|e| e.temperature.len() == nodes);
        if nodes < 2 || !ascending || !lengths || self.pressure.is_nan() || self.pressure <= 0.0 {
            return Err(FlowError::Profile { places: nodes, temperatures: self.temperature.len() });
        }
        Ok(self)
    }

    /// Gas temperature at `x`, K; beyond the ends that of the end.
    #[must_use]
    pub fn temperature(&self, x: f64) -> f64 {
        interpolate(&self.places, &self.temperature, x)
    }

    /// All gas properties at `x`.
    #[must_use]
    pub fn at(&self, x: f64) -> GasState {
        self.gas.at(self.temperature(x), self.pressure)
    }

    /// Speed of sound at `x`, m/s.
    #[must_use]
    pub fn sound_speed(&self, x: f64) -> f64 {
        self.at(x).sound_speed
    }

    /// Density at `x`, kg/m^3.
    #[must_use]
    pub fn density(&self, x: f64) -> f64 {
        self.at(x).density
    }

    /// Mean velocity of the gas at `x`, m/s.
    #[must_use]
    pub fn velocity(&self, x: f64) -> f64 {
        self.mass_flux / self.density(x)
    }

    /// Time a sound pulse takes from `from` up to `to`, carried by the flow: integral of dx/(c + u), s.
    #[must_use]
    pub fn travel_time(&self, from: f64, to: f64) -> f64 {
        (to - from) * self.mean(from, to, |g| 1.0 / (g.sound_speed + self.mass_flux / g.density))
    }

    /// The state with error component k at z_k standard deviations; missing entries of `z` count as zero.
    #[must_use]
    pub fn displaced(&self, z: &[f64]) -> Self {
        let mut state = self.clone();
        for (error, z) in self.errors.iter().zip(z) {
            state.mass_flux += z * error.mass_flux;
            state.heater_velocity += z * error.heater_velocity;
            for (t, d) in state.temperature.iter_mut().zip(&error.temperature) {
                *t += z * d;
            }
        }
        state
    }

    /// Standard deviation of the velocity at the heater, m/s.
    #[must_use]
    pub fn heater_velocity_sd(&self) -> f64 {
        self.errors.iter().map(|e| e.heater_velocity.powi(2)).sum::<f64>().sqrt()
    }

    /// Covariance of the sound speed at the places `at`, (m/s)^2, to first order in the errors.
    #[must_use]
    pub fn sound_speed_covariance(&self, at: &[f64]) -> Matrix {
        self.covariance(at, |g, gas, t| {
            let step = 1e-3;
            let (up, down) = (gas.at(t + step, g.pressure), gas.at(t - step, g.pressure));
            (up.sound_speed - down.sound_speed) / (2.0 * step)
        })
    }

    fn covariance(&self, at: &[f64], slope: impl Fn(&GasState, &Gas, f64) -> f64) -> Matrix {
        let slopes: Vec<f64> =
            at.iter().map(|&x| slope(&self.at(x), &self.gas, self.temperature(x))).collect();
        let mut covariance = Matrix::zeros(at.len(), at.len());
        for error in &self.errors {
            let change: Vec<f64> = (at.iter().zip(&slopes))
                .map(|(&x, s)| s * interpolate(&self.places, &error.temperature, x))
                .collect();
            for i in 0..at.len() {
                for j in 0..at.len() {
                    covariance[(i, j)] += change[i] * change[j];
                }
            }
        }
        covariance
    }

    /// Mean over [from, to] of a property, by three-point Gauss quadrature on each linear piece: errors below
    /// 1e-9 for pieces over which the temperature changes by less than a fifth.
    fn mean(&self, from: f64, to: f64, property: impl Fn(&GasState) -> f64) -> f64 {
        if to <= from {
            return property(&self.at(from));
        }
        let mut sum = 0.0;
        let inner = self.places.iter().copied().filter(|&p| p > from && p < to);
        let mut left = from;
        for right in inner.chain([to]) {
            let (middle, half) = (0.5 * (left + right), 0.5 * (right - left));
            let node = 0.6_f64.sqrt() * half;
            for (x, weight) in [(middle - node, 5.0 / 9.0), (middle, 8.0 / 9.0), (middle + node, 5.0 / 9.0)] {
                sum += half * weight * property(&self.at(x));
            }
            left = right;
        }
        sum / (to - from)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn ramp() -> BaseState {
        let mut state = BaseState::uniform(&Gas::air(), 101_325.0, 1.0, 293.15, 0.1).unwrap();
        state.places = vec![0.0, 0.4, 0.5, 1.0];
        state.temperature = vec![293.15, 293.15, 400.0, 360.0];
        state.errors[0].temperature = vec![0.1, 0.1, 1.0, 0.5];
        state.mass_flux = 0.3;
        state.checked().unwrap()
    }

    #[test]
    fn message_an_error_that_is_none_is_refused() {
        for sd in [-0.1, f64::NAN, f64::INFINITY] {
            let found = BaseState::uniform(&Gas::air(), 101_325.0, 1.0, 293.15, sd);
            let words = found.unwrap_err().to_string();
            assert!(words.starts_with("temperature_sd = ") && words.contains("zero or more"), "{words}");
        }
    }

    #[test]
    fn exact_cold_tube() {
        let state = BaseState::uniform(&Gas::air(), 101_325.0, 1.0, 293.15, 0.0).unwrap();
        assert_relative_eq!(state.travel_time(0.0, 0.95), 2.767_067e-3, max_relative = 2e-7);
        assert_eq!(state.velocity(0.3), 0.0);
        assert_eq!(state.sound_speed_covariance(&[0.1, 0.9]), Matrix::zeros(2, 2));
    }

    #[test]
    fn oracle_the_travel_time_against_a_fine_riemann_sum() {
        let state = ramp();
        let n = 200_000;
        let mut time = 0.0;
        for i in 0..n {
            let g = state.at(0.3 + 0.5 * (f64::from(i) + 0.5) / f64::from(n));
            time += 0.5 / f64::from(n) / (g.sound_speed + 0.3 / g.density);
        }
        assert_relative_eq!(state.travel_time(0.3, 0.8), time, max_relative = 1e-7);
    }

    #[test]
    fn oracle_covariance_is_that_of_displaced_states() {
        let (state, at) = (ramp(), [0.2, 0.45, 0.9]);
        let covariance = state.sound_speed_covariance(&at);
        let (up, down) = (state.displaced(&[1e-3]), state.displaced(&[-1e-3]));
        let slope = at.map(|x| (up.sound_speed(x) - down.sound_speed(x)) / 2e-3);
        for i in 0..3 {
            for j in 0..3 {
                assert_relative_eq!(covariance[(i, j)], slope[i] * slope[j], max_relative = 1e-6);
            }
        }
    }

    #[test]
    fn exact_unsound_states_are_refused() {
        let cold = BaseState::uniform(&Gas::air(), 101_325.0, 1.0, -3.0, 0.0);
        assert!(matches!(cold, Err(FlowError::Temperature { .. })));
        let mut state = ramp();
        state.places[1] = 0.6;
        assert!(matches!(state.checked(), Err(FlowError::Profile { .. })));
    }
}
