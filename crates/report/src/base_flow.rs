//! The record of the base flow, as `rijke flow` writes it (`flow.json`): the part of it that is drawn.

use rijke_studies::DataKind;
use serde::{Deserialize, Serialize};

/// Base flow of a campaign. What is not drawn here is skipped when the file is read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BaseFlow {
    /// Measured or virtual.
    pub kind: DataKind,
    /// Name of the rig.
    pub rig: String,
    /// One run per position of the heater.
    pub runs: Vec<FlowRun>,
}

impl BaseFlow {
    /// Fig. 2 as the text of an SVG file: velocity at the heater, and speed of sound along the tube.
    #[must_use]
    pub fn svg(&self) -> String {
        crate::figures::base_flow::figure(self).svg()
    }
}

/// What was inferred with the heater at one position.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FlowRun {
    /// Position of the heater, m.
    pub heater_m: f64,
    /// Unknowns of the flow model; the first six are the paper's parameters.
    pub unknowns: Vec<FlowUnknown>,
    /// The base flow at each power.
    pub powers: Vec<FlowAtPower>,
}

/// An unknown of the flow model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FlowUnknown {
    /// Name.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Most probable value.
    pub value: f64,
    /// Lower end of two standard deviations.
    pub low: f64,
    /// Upper end of two standard deviations.
    pub high: f64,
    /// Standard deviation of the posterior divided by that of the prior.
    pub shrinkage: f64,
}

/// The base flow at one power.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FlowAtPower {
    /// Power of the heater, W.
    pub power_w: f64,
    /// Velocity at the heater, m/s.
    pub heater_velocity: f64,
    /// Its standard deviation, m/s.
    pub heater_velocity_sd: f64,
    /// Along the tube.
    pub profile: Vec<FlowAt>,
}

/// The gas at one place.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FlowAt {
    /// Place, m from the bottom.
    pub x: f64,
    /// Temperature, K.
    pub temperature: f64,
    /// Speed of sound, m/s.
    pub sound_speed: f64,
    /// Its standard deviation, m/s.
    pub sound_speed_sd: f64,
}
