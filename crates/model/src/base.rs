//! An operating point with the state of its gas.

use crate::ModelError;
use rijke_flow::BaseState;
use rijke_rig::{OperatingPoint, PointObservations, Rig};

/// An operating point with the state of its gas.
#[derive(Clone, Debug, PartialEq)]
pub struct Conditions {
    /// The operating point.
    pub point: OperatingPoint,
    /// The gas along the tube.
    pub base: BaseState,
    /// Ambient temperature, K.
    pub ambient: f64,
}

impl Conditions {
    /// Gas at rest at `temperature` (K) with standard deviation `sd`: exact without power, where nothing drives a flow.
    ///
    /// # Errors
    /// [`ModelError::Flow`] for a temperature that is not positive.
    pub fn cold(rig: &Rig, point: OperatingPoint, temperature: f64, sd: f64) -> Result<Self, ModelError> {
        let base = BaseState::uniform(&rig.gas, rig.pressure, rig.tube.length, temperature, sd)
            .map_err(|source| ModelError::Flow { point: point.id.clone(), source })?;
        Ok(Self { point, base, ambient: temperature })
    }

    /// The cold conditions of a measured point: gas at the ambient temperature of its day.
    ///
    /// # Errors
    /// As [`Conditions::cold`].
    pub fn of_the_day(rig: &Rig, observed: &PointObservations) -> Result<Self, ModelError> {
        let day = &observed.ambient;
        Self::cold(rig, observed.point.clone(), day.ambient_temperature, day.ambient_temperature_sd)
    }

    /// An empty tube at `temperature` (K), known exactly.
    ///
    /// # Errors
    /// As [`Conditions::cold`].
    pub fn empty_tube(rig: &Rig, temperature: f64) -> Result<Self, ModelError> {
        let point = OperatingPoint {
            id: "empty tube".into(),
            row: String::new(),
            position: None,
            heater: false,
            thermocouples: false,
            power: 0.0,
            repeats: 0,
        };
        Self::cold(rig, point, temperature, 0.0)
    }
}
