//! States of the gas at operating points on disk, as a study reads them: `base/states.json`.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The file.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StatesFile {
    /// Name of the operating point, and its state.
    pub points: BTreeMap<String, StateRecord>,
}

/// One state.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StateRecord {
    /// kg/s.
    pub mass_flow: f64,
    /// Numbers for laws, by name, SI.
    pub numbers: BTreeMap<String, f64>,
    /// m.
    pub places: Vec<f64>,
    /// K.
    pub temperature: Vec<f64>,
    /// Zones in which the temperature changes fast, m.
    pub kinks: Vec<[f64; 2]>,
    /// Changes per standard deviation of each cause.
    pub errors: Vec<ErrorRecord>,
}

/// One standard deviation of one cause.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ErrorRecord {
    /// Its name: states that have the same share it.
    pub cause: String,
    /// kg/s.
    pub mass_flow: f64,
    /// By name, SI.
    pub numbers: BTreeMap<String, f64>,
    /// K.
    pub temperature: Vec<f64>,
}
