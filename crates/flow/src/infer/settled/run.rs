//! The readings of states that are settled or passed on a ramp, with the heater at one place.

use crate::apparatus::ramp::Ramp;
use crate::error::FlowError;
use crate::infer::sensor::{SensorKind, plausible};
use crate::tube::pipe::Pipe;
use rijke_numerics::Matrix;

/// The readings of one state.
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
    /// The run over time in which it was passed, by its place in [`SettledRun::ramps`], and when, s; none if
    /// it is settled.
    pub moment: Option<(usize, f64)>,
}

/// All states with the heater at one place.
#[derive(Clone, Debug, PartialEq)]
pub struct SettledRun {
    /// Centre of the heater, m.
    pub heater: f64,
    /// The states, in any order.
    pub states: Vec<State>,
    /// Covariance of the error that the arrival times of microphones i and j have in common in all states,
    /// s^2.
    pub common: Matrix,
    /// Standard deviation of the error that all other readings have in common, K or m/s.
    pub offset_sd: f64,
    /// Runs over time, of which some states are moments.
    pub ramps: Vec<Ramp>,
}

impl State {
    /// The run over time in which it was passed, by its place in [`SettledRun::ramps`].
    pub(crate) fn ramp(&self) -> Option<usize> {
        self.moment.map(|(ramp, _)| ramp)
    }
}

impl SettledRun {
    /// Whether a heated state was read; if not, all of them are foreseen from other places of the heater.
    pub(crate) fn is_read(&self) -> bool {
        self.states.iter().any(|s| s.power > 0.0 && !s.sensors.is_empty())
    }

    /// Refuses heated readings from which nothing can be inferred.
    ///
    /// # Errors
    /// [`FlowError::Point`] with [`FlowError::Power`] or [`FlowError::Range`], [`FlowError::Readings`],
    /// [`FlowError::TooFewSamples`], [`FlowError::Sensor`], [`FlowError::TwoDays`].
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
                    return Err(FlowError::Sensor { sensor: sensor.to_string() });
                }
            }
            plausible(state.power, state.ambient, &state.sensors, &state.readings)
                .map_err(|source| FlowError::Point { id: state.id.clone(), source: Box::new(source) })?;
            if let Some(first) = self.states.iter().find(|s| s.ramp() == state.ramp())
                && state.moment.is_some()
                && (&first.day, first.ambient) != (&state.day, state.ambient)
            {
                return Err(FlowError::TwoDays { first: first.id.clone(), second: state.id.clone() });
            }
            hot += if state.power > 0.0 { count } else { 0 };
        }
        let foreseen = !self.is_read() && self.states.iter().any(|s| s.power > 0.0);
        if !foreseen && hot < SIX {
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
pub(crate) const SIX: usize = 6;
