//! The truth file of a bench.

use super::ends::EndTruth;
use super::error::BenchError;
use super::parts::{BranchTruth, ObstacleTruth};
use super::response::SourceTruth;
use super::value::Value;
use crate::toml_file;
use rijke_rig::Gas;
use serde::Deserialize;
use std::path::Path;

/// All of a truth file. Lengths in m, temperatures in K, SI throughout.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct BenchTruth {
    pub(crate) name: String,
    /// The campaign beside the truth file.
    pub(crate) campaign: String,
    #[serde(default = "Gas::air")]
    pub(crate) gas: Gas,
    #[serde(default = "one_atmosphere")]
    pub(crate) pressure: f64,
    pub(crate) search: Search,
    /// Mean flow at ambient temperature, m^3/s.
    #[serde(default)]
    pub(crate) volume_flow: Option<Value>,
    pub(crate) upstream: EndTruth,
    pub(crate) downstream: EndTruth,
    pub(crate) duct: Vec<DuctTruth>,
    /// Whether changes of area and necks have their added mass.
    #[serde(default = "yes")]
    pub(crate) added_mass: bool,
    #[serde(default)]
    pub(crate) cooling: Cooling,
    #[serde(default)]
    pub(crate) source: Vec<SourceTruth>,
    #[serde(default)]
    pub(crate) obstacle: Vec<ObstacleTruth>,
    #[serde(default)]
    pub(crate) branch: Vec<BranchTruth>,
    pub(crate) microphones: Microphones,
    #[serde(default)]
    pub(crate) thermometers: Option<Thermometers>,
    pub(crate) noise: BenchNoise,
    /// What the truth means in the words of the competing laws; for people.
    #[serde(default)]
    #[allow(
        dead_code,
        reason = "a note that is read by people; named here so that other unknown keys are refused"
    )]
    expected: toml::Table,
}

/// Where all modes are looked for.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Search {
    pub(crate) growth_rate: [f64; 2],
    pub(crate) frequency_hz: [f64; 2],
    /// How many of them are observed, from the lowest frequency; all if absent.
    #[serde(default)]
    pub(crate) observed: Option<usize>,
}

/// A duct; the next one follows it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct DuctTruth {
    pub(crate) length: Value,
    pub(crate) diameter: f64,
    /// Factor on the boundary layers of a smooth wall; 0 for none.
    pub(crate) layers: f64,
}

/// How gas behind a source loses heat to walls at ambient temperature.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Cooling {
    /// Heat transfer coefficient, W/(m^2 K).
    pub(crate) coefficient: f64,
    /// What is added to it per kelvin of excess temperature, W/(m^2 K^2): radiation and buoyancy.
    #[serde(default)]
    pub(crate) per_kelvin: f64,
}

/// Microphones.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Microphones {
    pub(crate) at: Vec<f64>,
    /// Number of the reference, from 1.
    pub(crate) reference: usize,
    /// Numbers of those that hear nothing, from 1.
    #[serde(default)]
    pub(crate) dead: Vec<usize>,
}

/// Thermometers in the gas.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Thermometers {
    pub(crate) at: Vec<f64>,
    /// Share of the excess over ambient that a thermometer misses, by radiating to the wall.
    pub(crate) radiation: f64,
    /// What its maker says of that share: standard deviation about zero.
    pub(crate) radiation_sd: f64,
    /// Scatter of a reading, K.
    pub(crate) sd: f64,
}

/// Standard deviations of what is observed.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct BenchNoise {
    /// Of a growth rate, 1/s.
    pub(crate) growth_rate: f64,
    /// Of a frequency, Hz.
    pub(crate) frequency_hz: f64,
    /// Of the real and the imaginary part of a pressure relative to the reference.
    pub(crate) pressure: f64,
}

fn yes() -> bool {
    true
}

fn one_atmosphere() -> f64 {
    101_325.0
}

impl BenchTruth {
    pub(crate) fn read(path: &Path) -> Result<Self, BenchError> {
        let truth: Self = toml_file::read(path)?;
        let (reference, count) = (truth.microphones.reference, truth.microphones.at.len());
        if reference == 0 || reference > count {
            return Err(BenchError::Reference { reference, count });
        }
        Ok(truth)
    }
}
