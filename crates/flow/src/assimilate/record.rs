//! What was measured over time.

use crate::air::in_range;
use crate::draught::Draught;
use crate::number::Number;
use crate::{FlowError, Pipe, UNKNOWNS, Unknowns};
use serde::{Deserialize, Serialize};

/// One measured quantity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum SensorKind {
    /// Arrival time of a click at a microphone, s, counted from 0 in the rig's list.
    Arrival {
        /// Which microphone.
        microphone: usize,
    },
    /// Gas temperature, K, for a user with thermometers instead of clicks.
    Temperature {
        /// Where, m.
        place: f64,
    },
    /// Speed of sound, m/s, for a user who has it from elsewhere.
    SoundSpeed {
        /// Where, m.
        place: f64,
    },
}

/// A quantity with the sd of its noise and of its constant error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sensor {
    /// What it measures.
    pub kind: SensorKind,
    /// Standard deviation of the noise of one reading, in the unit of the quantity.
    pub sd: f64,
    /// Standard deviation of an error common to all readings: of a channel delay after calibration, of a thermometer.
    pub bias_sd: f64,
}

/// The readings at one time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Indicated power of the heater since the previous sample, W.
    pub power: f64,
    /// Indicated ambient temperature, K.
    pub ambient: f64,
    /// One reading per sensor.
    pub readings: Vec<f64>,
}

/// A run with one heater position: samples at equal intervals, from a cold start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Time between samples, s; also the time step of the model.
    pub interval: f64,
    /// What is measured.
    pub sensors: Vec<Sensor>,
    /// Standard deviation of one reading of the ambient thermometer, K.
    pub ambient_sd: f64,
    /// How fast the ambient temperature wanders, K per square root of a second.
    pub ambient_drift: f64,
    /// Standard deviation of one reading of the power, relative.
    pub power_sd: f64,
    /// The readings.
    pub samples: Vec<Sample>,
}

impl Record {
    /// Refuses a record from which nothing can be inferred.
    ///
    /// # Errors
    /// [`FlowError::NotCalibrated`] if the first sample is not taken without power (nothing fixes the channel delays
    /// then), [`FlowError::TooFewSamples`], [`FlowError::Readings`], [`FlowError::Sensor`], [`FlowError::Setting`], and
    /// [`FlowError::Sample`] with [`FlowError::Power`] or [`FlowError::Range`].
    pub fn checked(self, pipe: &Pipe) -> Result<Self, FlowError> {
        let positive = |v: f64| v.is_finite() && v > 0.0;
        let settings = [
            ("interval_s", self.interval, positive(self.interval), "positive"),
            ("ambient_sd_k", self.ambient_sd, positive(self.ambient_sd), "positive"),
            ("ambient_drift_k_per_root_s", self.ambient_drift, positive(self.ambient_drift), "positive"),
            ("power_sd", self.power_sd, self.power_sd == 0.0 || positive(self.power_sd), "zero or positive"),
        ];
        if let Some(&(name, value, _, must)) = settings.iter().find(|s| !s.2) {
            return Err(FlowError::Setting { name, value, must });
        }
        for sensor in &self.sensors {
            let known = match sensor.kind {
                SensorKind::Arrival { microphone } => microphone < pipe.microphones.len(),
                SensorKind::Temperature { place } | SensorKind::SoundSpeed { place } => {
                    (0.0..=pipe.length).contains(&place)
                }
            };
            if !known
                || sensor.sd.is_nan()
                || sensor.sd <= 0.0
                || sensor.bias_sd.is_nan()
                || sensor.bias_sd < 0.0
            {
                return Err(FlowError::Sensor { sensor: format!("{sensor:?}") });
            }
        }
        let unknown = UNKNOWNS + self.sensors.iter().filter(|s| s.bias_sd > 0.0).count();
        let have = self.samples.len() * self.sensors.len();
        if have < unknown {
            return Err(FlowError::TooFewSamples { have, need: unknown });
        }
        let kinds: Vec<SensorKind> = self.sensors.iter().map(|s| s.kind).collect();
        for (index, sample) in self.samples.iter().enumerate() {
            let finite = sample.readings.iter().all(|r| r.is_finite());
            if sample.readings.len() != self.sensors.len() || !finite {
                return Err(FlowError::Readings {
                    index,
                    got: sample.readings.len(),
                    need: self.sensors.len(),
                });
            }
            plausible(sample.power, sample.ambient, &kinds, &sample.readings)
                .map_err(|source| FlowError::Sample { index, source: Box::new(source) })?;
        }
        let arrivals = self.sensors.iter().any(|s| matches!(s.kind, SensorKind::Arrival { .. }));
        match self.samples.first() {
            Some(first) if arrivals && first.power > 0.0 => {
                Err(FlowError::NotCalibrated { watts: first.power })
            }
            _ => Ok(self),
        }
    }

    /// The sensors that have a constant error of their own.
    pub(crate) fn biased(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.sensors.iter().enumerate().filter(|(_, s)| s.bias_sd > 0.0).map(|(i, s)| (i, s.bias_sd))
    }
}

/// Refuses a power that is negative, and temperatures at which the properties of air do not hold.
pub(crate) fn plausible(
    power: f64,
    ambient: f64,
    sensors: &[SensorKind],
    readings: &[f64],
) -> Result<(), FlowError> {
    if !power.is_finite() || power < 0.0 {
        return Err(FlowError::Power { watts: power });
    }
    in_range("the ambient temperature", ambient)?;
    for (sensor, &kelvin) in sensors.iter().zip(readings) {
        if let SensorKind::Temperature { place } = sensor {
            in_range(&format!("the gas at x = {place} m"), kelvin)?;
        }
    }
    Ok(())
}

/// What every sensor would read, without its constant error.
pub(crate) fn observe<N: Number>(
    pipe: &Pipe,
    sensors: &[Sensor],
    gas: &Draught<N>,
    unknowns: &Unknowns<N>,
    times: &mut Vec<N>,
    out: &mut Vec<N>,
) {
    times.clear();
    if sensors.iter().any(|s| matches!(s.kind, SensorKind::Arrival { .. })) {
        pipe.arrival_times(gas, unknowns.orifice_length, times);
    }
    let temperature = |place: f64| {
        let upper = pipe.faces.partition_point(|&f| f <= place).clamp(1, pipe.faces.len() - 1);
        let share = (place - pipe.faces[upper - 1]) / (pipe.faces[upper] - pipe.faces[upper - 1]);
        gas.march.face[upper - 1] * (1.0 - share) + gas.march.face[upper] * share
    };
    out.clear();
    out.extend(sensors.iter().map(|s| match s.kind {
        SensorKind::Arrival { microphone } => times[microphone],
        SensorKind::Temperature { place } => temperature(place),
        SensorKind::SoundSpeed { place } => pipe.air.sound_speed(temperature(place)),
    }));
}
