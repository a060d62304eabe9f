//! One operating point.

use std::collections::BTreeMap;

/// One configuration of the rig, by its factors.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OperatingPoint {
    /// Unique name, also a folder name: `"C3-E"`, `"C3-05"`, `"H180-25"`.
    pub id: String,
    /// Row of the campaign that it belongs to, `"C3"`; may be empty.
    pub row: String,
    /// Number of repeats measured.
    pub repeats: u32,
    /// What was set or measured there, by name. A factor that the point does not have is absent.
    pub factors: BTreeMap<String, FactorValue>,
}

/// The value of a factor at one operating point.
#[derive(Clone, Debug, PartialEq)]
pub struct FactorValue {
    /// In SI.
    pub value: f64,
    /// Its unit in SI, `m` or `kg s^-1`; `1` for a pure number.
    pub unit: String,
}

impl OperatingPoint {
    /// The largest number of letters in a name.
    pub const LONGEST: usize = 100;

    /// The value of a factor in SI; none if the point does not have it.
    #[must_use]
    pub fn factor(&self, name: &str) -> Option<f64> {
        self.factors.get(name).map(|factor| factor.value)
    }
}
