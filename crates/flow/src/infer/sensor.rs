//! What a sensor measures, and whether a reading can be true.

use crate::error::FlowError;
use crate::tube::air::in_range;
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

impl SensorKind {
    /// Least and largest standard deviation of a reading, s, K or m/s: nothing is read better or worse.
    pub(crate) fn sds(self) -> [f64; 2] {
        match self {
            Self::Arrival { .. } => [1e-8, 1.0],
            Self::Temperature { .. } | Self::SoundSpeed { .. } => [1e-3, 1e3],
        }
    }
}

impl std::fmt::Display for SensorKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Arrival { microphone } => write!(f, "arrival at microphone {microphone}"),
            Self::Temperature { place } => write!(f, "thermometer at x = {place} m"),
            Self::SoundSpeed { place } => write!(f, "speed of sound at x = {place} m"),
        }
    }
}

/// A quantity with the sd of its noise and of its constant error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sensor {
    /// What it measures.
    pub kind: SensorKind,
    /// Standard deviation of the noise of one reading, in the unit of the quantity.
    pub sd: f64,
    /// Standard deviation of an error common to all readings: of a channel delay after calibration, of a
    /// thermometer.
    pub bias_sd: f64,
}

/// Refuses a power that is negative, temperatures at which the properties of air do not hold, and times and
/// speeds that no sound has.
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
    for (sensor, &reading) in sensors.iter().zip(readings) {
        match sensor {
            SensorKind::Temperature { place } => in_range(&format!("the gas at x = {place} m"), reading)?,
            SensorKind::Arrival { microphone } => {
                if !(reading > 0.0 && reading < 1.0) {
                    let what = format!("the arrival time at microphone {microphone}");
                    return Err(FlowError::Reading { what, value: reading, must: "above 0 and below 1 s" });
                }
            }
            SensorKind::SoundSpeed { place } => {
                if !(200.0..=1500.0).contains(&reading) {
                    let what = format!("the speed of sound at x = {place} m");
                    return Err(FlowError::Reading { what, value: reading, must: "200 to 1500 m/s" });
                }
            }
        }
    }
    Ok(())
}
