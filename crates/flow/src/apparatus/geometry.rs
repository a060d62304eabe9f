//! The rig: tube, gas, microphones, thermometers, insert, plates, recording.

use rijke_rig::{Apparatus, DuctSize, Gas, Microphones, Recording};
use serde::{Deserialize, Serialize};

/// A vertical tube with one heat source on insert, as in Juniper & Yoko 2022, section 3.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TubeRig {
    /// What the rig is called in reports.
    pub name: String,
    /// Where the numbers come from.
    pub source: String,
    /// The tube.
    pub tube: Tube,
    /// The gas in it.
    pub gas: Gas,
    /// Ambient pressure, Pa.
    pub pressure: f64,
    /// The microphones.
    pub microphones: Microphones,
    /// Positions of the thermometers along the tube, m.
    #[serde(default)]
    pub thermometers: Vec<f64>,
    /// What holds and feeds the plates, entering from x = 0.
    pub insert: Insert,
    /// The plates.
    pub plates: Plates,
    /// How records are taken.
    pub recording: TubeRecording,
}

/// A straight round tube, open at both ends unless a model says otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tube {
    /// Length, m.
    pub length: f64,
    /// Inner diameter, m.
    pub inner_diameter: f64,
    /// Thickness of the wall, m.
    pub wall_thickness: f64,
}

/// Threaded rods and feed wires that enter from x = 0 and end at the plates.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Insert {
    /// Number of rods.
    pub rods: u32,
    /// Diameter of a rod, m.
    pub rod_diameter: f64,
    /// Number of feed wires.
    pub wires: u32,
    /// Diameter of a feed wire, m.
    pub wire_diameter: f64,
}

/// Two annular plates wound with wire (Fig. 1 of the paper).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plates {
    /// Outer diameter of the plates, m.
    pub outer_diameter: f64,
    /// Diameter of the central hole, m.
    pub inner_diameter: f64,
    /// Thickness of one plate, m.
    pub plate_thickness: f64,
    /// Gap between the plates, m.
    pub plate_gap: f64,
    /// Diameter of the heating wire, m.
    pub wire_diameter: f64,
}

/// Sampling rates and timing of the records.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TubeRecording {
    /// Sampling rate of pings, Hz.
    pub ping_rate_hz: f64,
    /// Sampling rate of clicks, Hz.
    pub click_rate_hz: f64,
    /// As in [`Recording`].
    #[serde(default)]
    pub arrival_setting_sd_s: f64,
    /// As in [`Recording`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ping_decay_times: Option<f64>,
}

impl TubeRig {
    /// The rig as signal processing knows it.
    #[must_use]
    pub fn apparatus(&self) -> Apparatus {
        Apparatus {
            name: self.name.clone(),
            source: self.source.clone(),
            duct: DuctSize { length: self.tube.length, inner_diameter: self.tube.inner_diameter },
            gas: self.gas.clone(),
            pressure: self.pressure,
            microphones: self.microphones.clone(),
            recording: Recording {
                arrival_setting_sd_s: self.recording.arrival_setting_sd_s,
                ping_decay_times: self.recording.ping_decay_times,
            },
        }
    }
}

impl Tube {
    /// Inner radius, m.
    #[must_use]
    pub fn radius(&self) -> f64 {
        0.5 * self.inner_diameter
    }

    /// Inner cross-section, m^2.
    #[must_use]
    pub fn area(&self) -> f64 {
        std::f64::consts::PI * self.radius().powi(2)
    }

    /// Inner perimeter, m.
    #[must_use]
    pub fn perimeter(&self) -> f64 {
        std::f64::consts::PI * self.inner_diameter
    }
}

impl Insert {
    /// Sum of the perimeters of rods and wires, m.
    #[must_use]
    pub fn perimeter(&self) -> f64 {
        let diameters = f64::from(self.rods) * self.rod_diameter + f64::from(self.wires) * self.wire_diameter;
        std::f64::consts::PI * diameters
    }

    /// Sum of the cross-sections of rods and wires, m^2.
    #[must_use]
    pub fn area(&self) -> f64 {
        let squares = f64::from(self.rods) * self.rod_diameter.powi(2)
            + f64::from(self.wires) * self.wire_diameter.powi(2);
        0.25 * std::f64::consts::PI * squares
    }
}

impl Plates {
    /// Length along the tube: two plates and the gap, m.
    #[must_use]
    pub fn length(&self) -> f64 {
        2.0 * self.plate_thickness + self.plate_gap
    }

    /// Open area of a plate, m^2.
    #[must_use]
    pub fn open_area(&self) -> f64 {
        0.25 * std::f64::consts::PI * self.inner_diameter.powi(2)
    }
}
