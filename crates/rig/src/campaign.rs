//! The campaign: which operating points were measured, and how often (Table 1 of the paper).

use serde::{Deserialize, Serialize};

/// All operating points of a campaign, in the order of its file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Default)]
pub struct Campaign {
    /// What the campaign is called in reports.
    pub name: String,
    /// The operating points.
    pub points: Vec<OperatingPoint>,
}

/// One configuration of the rig at one power.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OperatingPoint {
    /// Unique name, also a folder name: row and position, `"C3-E"`, `"C3-35"`, `"H180-25"`.
    pub id: String,
    /// Row of the campaign, `"C3"`.
    pub row: String,
    /// Where the prongs end and the heater (if attached) sits, m from x = 0; none for the empty tube.
    pub position: Option<f64>,
    /// Whether the heater is attached to the prongs.
    pub heater: bool,
    /// Whether the thermocouples are in place.
    pub thermocouples: bool,
    /// Electrical power of the heater, W.
    pub power: f64,
    /// Number of repeats measured.
    pub repeats: u32,
}
