//! Reading the apparatus from its file, and checking it.

use super::geometry::Apparatus;
use crate::error::RigError;
use crate::files::{in_range, parse_toml, read_text};
use crate::problem::Problem;
use std::path::Path;

impl Apparatus {
    /// Name of the file among observations, and among records that do not name another.
    pub const FILE: &'static str = "rig.toml";

    /// Reads and validates a file (TOML; `crates/rig/data/rig.toml` is commented).
    ///
    /// # Errors
    /// The file, the line or key, and the remedy.
    pub fn read(path: &Path) -> Result<Self, RigError> {
        Self::parse(&read_text(path)?, path)
    }

    /// As [`Apparatus::read`], from text; `path` appears in messages only.
    ///
    /// # Errors
    /// As [`Apparatus::read`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, RigError> {
        let rig: Self = parse_toml(text, path)?;
        rig.validate().map_err(|(place, problem)| RigError::invalid(path, place, problem))?;
        Ok(rig)
    }

    /// Checks ranges, and that microphones stand in the duct.
    ///
    /// # Errors
    /// Key and problem of the first value that makes no sense.
    pub fn validate(&self) -> Result<(), (String, Problem)> {
        let length = self.duct.length;
        in_range("duct.length", length, 1e-3, 1e3, "m")?;
        in_range("duct.inner_diameter", self.duct.inner_diameter, 1e-4, length, "m")?;
        in_range("pressure", self.pressure, 1e3, 1e7, "Pa")?;
        self.gas.validate()?;
        let setting = self.recording.arrival_setting_sd_s;
        in_range("recording.arrival_setting_sd_s", setting, 0.0, 1e-2, "s")?;
        if let Some(times) = self.recording.ping_decay_times {
            in_range("recording.ping_decay_times", times, 2.0, 16.0, "decay times")?;
        }
        if self.microphones.positions.is_empty() {
            return Err(("microphones.positions".into(), Problem::Empty { need: "one position" }));
        }
        along("microphones.positions", &self.microphones.positions, length)?;
        let (index, count) = (self.microphones.reference, self.microphones.positions.len());
        if index >= count {
            return Err(("microphones.reference".into(), Problem::NoSuchIndex { index, count }));
        }
        Ok(())
    }
}

/// Positions along a duct of this length (m): inside it, ascending, distinct.
///
/// # Errors
/// The first that is not, under the key `place`.
pub fn along(place: &str, positions: &[f64], length: f64) -> Result<(), (String, Problem)> {
    for (k, &position) in positions.iter().enumerate() {
        if !(position > 0.0 && position < length) {
            return Err((format!("{place}[{k}]"), Problem::OutsideTube { position, length }));
        }
    }
    for (k, pair) in positions.windows(2).enumerate() {
        if pair[1] <= pair[0] {
            let problem = Problem::NotAscending { first: pair[0], second: pair[1] };
            return Err((format!("{place}[{}]", k + 1), problem));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const RIG: &str = include_str!("../../data/rig.toml");

    #[track_caller]
    fn refused(old: &str, new: &str, message: &str) {
        assert!(RIG.contains(old), "{old}");
        let text = RIG.replacen(old, new, 1);
        let error = Apparatus::parse(&text, Path::new("a/rig.toml")).unwrap_err().to_string();
        assert_eq!(error, message);
    }

    #[test]
    fn exact_an_apparatus_is_read_and_survives_a_round_trip() {
        let rig = Apparatus::parse(RIG, Path::new("x")).unwrap();
        assert_eq!(rig.microphones.positions.len(), 8);
        assert_eq!(rig.microphones.positions[rig.microphones.reference], 0.75);
        assert_eq!(rig.gas, crate::apparatus::gas::Gas::air());
        assert_eq!(rig.recording.arrival_setting_sd_s, 2.1e-6);
        assert_eq!(Apparatus::parse(&toml::to_string(&rig).unwrap(), Path::new("x")).unwrap(), rig);
    }

    #[test]
    fn exact_messages_of_a_wrong_apparatus() {
        refused(
            "0.25, 0.35",
            "0.25, 1.35",
            "a/rig.toml: microphones.positions[1]: x = 1.35 m is outside the tube (0 to 1 m); positions are metres \
             from the bottom end",
        );
        refused(
            "0.25, 0.35",
            "0.35, 0.25",
            "a/rig.toml: microphones.positions[1]: 0.25 m follows 0.35 m; list positions from the bottom of the \
             tube upward, each once",
        );
        refused(
            "inner_diameter = 0.0474",
            "inner_diamter = 0.0474",
            "a/rig.toml:10:1: there is no key `inner_diamter`; did you mean `inner_diameter`? Known here: length, inner_diameter",
        );
        refused(
            "reference = 5",
            "reference = 8",
            "a/rig.toml: microphones.reference: 8 does not exist: there are 8, counted from 0",
        );
        refused(
            "length = 1.0",
            "length = nan",
            "a/rig.toml: duct.length: NaN m is outside 0.001 to 1000 m; give SI units",
        );
    }
}
