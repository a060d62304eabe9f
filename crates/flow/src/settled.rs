//! From readings of settled states to base states: one heater position, several powers, each long after its step.
//!
//! This serves a campaign that keeps the mean click of every operating point, and users with thermometers or a sound
//! speed profile instead. Without the warm-up the wall is seen only through its settled effect, so less is known than
//! from [`crate::assimilate::Batch`]; what the closures leave open then matters, and is inferred along with the six
//! parameters under priors that say what handbooks and geometry leave open ([`unknowns`]). The posterior therefore holds
//! the error of the model as far as these closures describe it.
//!
//! # Likelihood
//!
//! All readings of all states together are one Gaussian vector, with noise per state ([`State::noise`]) and an error of the
//! arrival times that is common to all states ([`Run::common`]).

mod errors;
mod fit;
mod observed;
mod prediction;
mod readings;
mod report;
#[cfg(test)]
mod tests;
mod unknowns;

pub use fit::{Fit, Misfit, Settled};
pub use observed::runs;
pub use readings::Readings;
pub use unknowns::unknowns;

use crate::assimilate::{SensorKind, plausible};
use crate::{FlowError, Pipe};
use rijke_numerics::Matrix;

/// The readings of one settled state.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Name of the operating point.
    pub id: String,
    /// Indicated power, W.
    pub power: f64,
    /// Indicated ambient temperature, K.
    pub ambient: f64,
    /// Standard deviation of the thermometer's constant error, K: common to states with the same `day`.
    pub ambient_sd: f64,
    /// The day: states of one day share the error of the thermometer.
    pub day: String,
    /// What is read: arrival times in s after channel delays and cold dispersion were removed, K, or m/s.
    pub sensors: Vec<SensorKind>,
    /// One reading per sensor.
    pub readings: Vec<f64>,
    /// Covariance of the readings' own noise.
    pub noise: Matrix,
}

/// All settled states with the heater at one place.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Centre of the heater, m.
    pub heater: f64,
    /// The states, in any order.
    pub states: Vec<State>,
    /// Covariance of the error that the arrival times of microphones i and j have in common in all states, s^2.
    pub common: Matrix,
}

impl Run {
    /// Refuses what nothing can be inferred from.
    ///
    /// # Errors
    /// [`FlowError::Point`] with [`FlowError::Power`] or [`FlowError::Range`], [`FlowError::Readings`],
    /// [`FlowError::TooFewSamples`], [`FlowError::Sensor`].
    pub fn checked(self, pipe: &Pipe) -> Result<Self, FlowError> {
        let mut hot = 0;
        for (index, state) in self.states.iter().enumerate() {
            let count = state.sensors.len();
            if state.readings.len() != count
                || state.noise.rows() != count
                || state.readings.iter().any(|r| !r.is_finite())
            {
                return Err(FlowError::Readings { index, got: state.readings.len(), need: count });
            }
            for sensor in &state.sensors {
                let known = match *sensor {
                    SensorKind::Arrival { microphone } => {
                        microphone < pipe.microphones.len() && microphone < self.common.rows()
                    }
                    SensorKind::Temperature { place } | SensorKind::SoundSpeed { place } => {
                        (0.0..=pipe.length).contains(&place)
                    }
                };
                if !known {
                    return Err(FlowError::Sensor { sensor: format!("{sensor:?}") });
                }
            }
            plausible(state.power, state.ambient, &state.sensors, &state.readings)
                .map_err(|source| FlowError::Point { id: state.id.clone(), source: Box::new(source) })?;
            hot += if state.power > 0.0 { count } else { 0 };
        }
        if hot < SIX {
            return Err(FlowError::TooFewSamples { have: hot, need: SIX });
        }
        Ok(self)
    }

    /// The days, each once, in the order of the states.
    pub(crate) fn days(&self) -> Vec<&str> {
        let mut days: Vec<&str> = Vec::new();
        for state in &self.states {
            if !days.contains(&state.day.as_str()) {
                days.push(&state.day);
            }
        }
        days
    }
}

/// The parameters of the paper.
const SIX: usize = 6;
