//! What sound passes on its way along the duct.

use crate::files::in_range;
use crate::problem::Problem;
use serde::{Deserialize, Serialize};

/// The way of sound from the lower end of the duct at one operating point, as far as it is not that of the
/// empty duct at ambient temperature.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Way {
    /// Whether gas on the way may be hotter than the surroundings.
    #[serde(default)]
    pub hot: bool,
    /// Stretches in which something stands along the duct. They do not overlap.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stretches: Vec<Stretch>,
}

/// A stretch of the duct whose boundary layers are not those of its wall alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stretch {
    /// Where it begins, m.
    pub from: f64,
    /// Where it ends, m.
    pub to: f64,
    /// Wetted perimeter over twice the open area, 1/m: one over the radius in an empty round duct.
    #[serde(rename = "wetted_per_m")]
    pub wetted: f64,
    /// Standard deviation of what the wetted perimeter exceeds the duct's own by, relative to that excess.
    #[serde(default)]
    pub excess_sd: f64,
}

impl Way {
    /// Checks places and numbers in a duct of this length (m).
    ///
    /// # Errors
    /// Key and problem of the first number that makes no sense.
    pub(crate) fn validate(&self, place: &str, length: f64) -> Result<(), (String, Problem)> {
        let mut before = 0.0;
        for (k, stretch) in self.stretches.iter().enumerate() {
            let key = |name: &str| format!("{place}: way.stretches[{k}].{name}");
            in_range(&key("from"), stretch.from, before, length, "m")?;
            in_range(&key("to"), stretch.to, stretch.from, length, "m")?;
            in_range(&key("wetted_per_m"), stretch.wetted, 0.0, 1e6, "1/m")?;
            in_range(&key("excess_sd"), stretch.excess_sd, 0.0, 10.0, "")?;
            before = stretch.to;
        }
        Ok(())
    }
}
