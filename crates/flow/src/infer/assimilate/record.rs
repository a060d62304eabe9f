//! What was measured over time.

use crate::error::FlowError;
use crate::infer::sensor::{Sensor, SensorKind, plausible};
use crate::number::Number;
use crate::tube::draught::Draught;
use crate::tube::parameters::{UNKNOWNS, Unknowns};
use crate::tube::pipe::Pipe;
use serde::{Deserialize, Serialize};

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
pub struct FlowRecord {
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

/// Most samples of a run: three days at the usual interval of 15 s, and more than enough for what settles
/// within hours.
const MOST_SAMPLES: usize = 20_000;

impl FlowRecord {
    /// Refuses a record from which nothing can be inferred.
    ///
    /// # Errors
    /// [`FlowError::NotCalibrated`] if the first sample is not taken without power (nothing fixes the channel
    /// delays then), [`FlowError::TooFewSamples`], [`FlowError::TooManySamples`], [`FlowError::Readings`],
    /// [`FlowError::Sensor`], [`FlowError::Setting`], and [`FlowError::Sample`] with [`FlowError::Power`] or
    /// [`FlowError::Range`].
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
            let [least, most] = sensor.kind.sds();
            let sds = (least..=most).contains(&sensor.sd) && (0.0..=most).contains(&sensor.bias_sd);
            if !known || !sds {
                return Err(FlowError::Sensor { sensor: sensor.kind.to_string() });
            }
        }
        let unknown = UNKNOWNS + self.sensors.iter().filter(|s| s.bias_sd > 0.0).count();
        let have = self.samples.len() * self.sensors.len();
        if have < unknown {
            return Err(FlowError::TooFewSamples { have, need: unknown });
        }
        if self.samples.len() > MOST_SAMPLES {
            return Err(FlowError::TooManySamples { have: self.samples.len(), most: MOST_SAMPLES });
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
