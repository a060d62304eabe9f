//! Reading a rig from its file, and checking it.

use super::geometry::TubeRig;
use rijke_rig::files::{in_range, parse_toml, read_text};
use rijke_rig::{Problem, RigError, along};
use std::path::Path;

impl TubeRig {
    /// Reads and validates a rig file (TOML).
    ///
    /// # Errors
    /// The file, the line or key, and the remedy.
    pub fn read(path: &Path) -> Result<Self, RigError> {
        Self::parse(&read_text(path)?, path)
    }

    /// As [`TubeRig::read`], from text; `path` appears in messages only.
    ///
    /// # Errors
    /// As [`TubeRig::read`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, RigError> {
        let rig: Self = parse_toml(text, path)?;
        rig.validate().map_err(|(place, problem)| RigError::invalid(path, place, problem))?;
        Ok(rig)
    }

    /// The rig of the paper, `crates/flow/data/rigs/juniper-yoko-2022.toml`, which carries the source of
    /// every value.
    #[must_use]
    #[allow(clippy::expect_used, reason = "the text is part of the program and a test parses it")]
    pub fn juniper_yoko_2022() -> Self {
        let text = include_str!("../../data/rigs/juniper-yoko-2022.toml");
        Self::parse(text, Path::new("juniper-yoko-2022.toml")).expect("the rig of the paper is valid")
    }

    /// Checks ranges and that everything fits.
    ///
    /// # Errors
    /// Key and problem of the first value that makes no sense.
    pub fn validate(&self) -> Result<(), (String, Problem)> {
        let metres = |place: &str, value: f64, low: f64, high: f64| in_range(place, value, low, high, "m");
        let (tube, insert, plates) = (&self.tube, &self.insert, &self.plates);
        metres("tube.length", tube.length, 1e-3, 1e3)?;
        metres("tube.inner_diameter", tube.inner_diameter, 1e-4, tube.length)?;
        metres("tube.wall_thickness", tube.wall_thickness, 0.0, tube.length)?;
        in_range("recording.ping_rate_hz", self.recording.ping_rate_hz, 1.0, 1e7, "Hz")?;
        in_range("recording.click_rate_hz", self.recording.click_rate_hz, 1.0, 1e7, "Hz")?;
        self.apparatus().validate()?;
        along("thermometers", &self.thermometers, tube.length)?;
        metres("insert.rod_diameter", insert.rod_diameter, 0.0, tube.inner_diameter)?;
        metres("insert.wire_diameter", insert.wire_diameter, 0.0, tube.inner_diameter)?;
        metres("plates.plate_thickness", plates.plate_thickness, 0.0, tube.length)?;
        metres("plates.plate_gap", plates.plate_gap, 0.0, tube.length)?;
        metres("plates.wire_diameter", plates.wire_diameter, 0.0, plates.outer_diameter)?;
        let fits = |place: &str, inner: f64, outer: f64| match inner < outer {
            true => Ok(()),
            false => Err((place.to_owned(), Problem::DoesNotFit { inner, outer })),
        };
        fits("plates.outer_diameter", plates.outer_diameter, tube.inner_diameter)?;
        fits("plates.inner_diameter", plates.inner_diameter, plates.outer_diameter)?;
        let blocked = 2.0 * (insert.area() / std::f64::consts::PI).sqrt();
        fits("insert", blocked, tube.inner_diameter)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paper() -> String {
        include_str!("../../data/rigs/juniper-yoko-2022.toml").to_owned()
    }

    #[track_caller]
    fn refused(old: &str, new: &str, message: &str) {
        let text = paper();
        assert!(text.contains(old), "{old}");
        let error =
            TubeRig::parse(&text.replacen(old, new, 1), Path::new("a/rig.toml")).unwrap_err().to_string();
        assert_eq!(error, message);
    }

    #[test]
    fn paper_rig_is_read_and_survives_a_round_trip() {
        let rig = TubeRig::juniper_yoko_2022();
        assert_eq!(rig.microphones.positions.len(), 8);
        assert_eq!(rig.microphones.positions[rig.microphones.reference], 0.75);
        assert_eq!(rig.gas, rijke_rig::Gas::air());
        let again = TubeRig::parse(&toml::to_string(&rig).unwrap(), Path::new("x")).unwrap();
        assert_eq!(again, rig);
    }

    #[test]
    fn exact_messages_of_a_wrong_rig() {
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
            "a/rig.toml:11:1: there is no key `inner_diamter`; did you mean `inner_diameter`? Known here: length, \
             inner_diameter, wall_thickness",
        );
        refused(
            "reference = 5",
            "reference = 8",
            "a/rig.toml: microphones.reference: 8 does not exist: there are 8, counted from 0",
        );
        refused(
            "outer_diameter = 0.047 ",
            "outer_diameter = 0.47 ",
            "a/rig.toml: plates.outer_diameter: 0.47 m does not fit inside 0.0474 m; check both diameters",
        );
        refused(
            "length = 1.0",
            "length = nan",
            "a/rig.toml: tube.length: NaN m is outside 0.001 to 1000 m; give SI units",
        );
    }
}
