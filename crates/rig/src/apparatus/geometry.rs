//! The rig as signal processing needs it: duct, gas, microphones, recording.

use super::gas::Gas;
use serde::{Deserialize, Serialize};

/// A duct with microphones along it. What stands in it, and what heats, is no part of this: see
/// [`crate::Way`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Apparatus {
    /// What the rig is called in reports.
    pub name: String,
    /// Where the numbers come from.
    pub source: String,
    /// The duct.
    pub duct: DuctSize,
    /// The gas in it.
    pub gas: Gas,
    /// Ambient pressure, Pa.
    pub pressure: f64,
    /// The microphones.
    pub microphones: Microphones,
    /// How records are taken.
    #[serde(default)]
    pub recording: Recording,
}

/// A straight duct along which clicks run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DuctSize {
    /// Length, m.
    pub length: f64,
    /// Inner diameter, m; of several ducts, that of the widest; of one that is not round, that of a circle of
    /// the same area.
    pub inner_diameter: f64,
}

/// Probe microphones along the duct.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Microphones {
    /// Positions, m, in the order of the channels.
    pub positions: Vec<f64>,
    /// Index of the microphone to which pressures are relative.
    pub reference: usize,
    /// What they are called, if not `p1`, `p2`, ...
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub names: Vec<String>,
}

impl Microphones {
    /// What each is called. Where some are left out of the positions, all go by their numbers.
    #[must_use]
    pub fn called(&self) -> Vec<String> {
        let count = self.positions.len();
        if self.names.len() == count { self.names.clone() } else { Self::by_number(count) }
    }

    /// `p1`, `p2`, ...
    #[must_use]
    pub fn by_number(count: usize) -> Vec<String> {
        (1..=count).map(|m| format!("p{m}")).collect()
    }
}

/// What is known of how the records of a rig are taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recording {
    /// Standard deviation of a shift of all arrival times alike between one installation of the rig and that
    /// of the calibration, s: each time the rig is set anew its mouths, or its loudspeaker, come out a little
    /// different. No record of the installation itself shows it.
    #[serde(default)]
    pub arrival_setting_sd_s: f64,
    /// Decay times of a ring-down that the fit of a ping uses, 2 to 16; 7 if not stated: beyond them lies
    /// 0.03 % of the information on the growth rate. Fewer leave out what is near the noise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ping_decay_times: Option<f64>,
}

impl DuctSize {
    /// Inner radius, m.
    #[must_use]
    pub fn radius(&self) -> f64 {
        0.5 * self.inner_diameter
    }
}
