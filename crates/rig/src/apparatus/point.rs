//! One operating point.

use serde::{Deserialize, Serialize};

/// One configuration of the rig at one power.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OperatingPoint {
    /// Unique name, also a folder name: row and position in cm, `"C3-E"`, `"C3-05"`, `"H180-25"`.
    pub id: String,
    /// Row of the campaign, `"C3"`.
    pub row: String,
    /// Where the insert end and the plates (if attached) sits, m from x = 0; none for the empty tube.
    pub position: Option<f64>,
    /// Whether the plates is attached to the insert.
    pub plates: bool,
    /// Whether the thermometers are in place.
    pub thermometers: bool,
    /// Electrical power of the plates, W.
    pub power: f64,
    /// Number of repeats measured.
    pub repeats: u32,
}
