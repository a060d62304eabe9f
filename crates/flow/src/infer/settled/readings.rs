//! Readings of thermometers or of the speed of sound along the tube, for users without clicks.

use crate::base::table::{at, readings};
use crate::error::FlowError;
use crate::infer::sensor::SensorKind;
use std::collections::BTreeMap;
use std::path::Path;

/// Readings of one operating point.
pub(crate) type OfPoint = Vec<(SensorKind, f64, f64)>;

/// Readings along the tube by operating point: `readings.csv` beside the observations.
///
/// One row per reading, with the columns `point`, `at [m]`, `temperature [K]` or `sound_speed [m/s]`, and
/// `sd`, the standard deviation of the reading in its unit by itself; with `offset_sd`, one number in all
/// rows, that of an error that all readings have in common, of a reference junction say.
#[derive(Clone, Debug, Default)]
pub struct Readings {
    pub(crate) points: BTreeMap<String, OfPoint>,
    /// Standard deviation of the common error, K or m/s.
    pub(crate) offset_sd: f64,
}

impl Readings {
    /// Name of the file in a folder of observations.
    pub const FILE: &'static str = "readings.csv";

    /// Reads the file; `known` says whether an operating point exists.
    ///
    /// # Errors
    /// [`FlowError::File`] with the line and what is wrong in it.
    pub fn read(path: &Path, known: &dyn Fn(&str) -> bool) -> Result<Self, FlowError> {
        let (by_speed, rows) = readings(path)?;
        let mut points: BTreeMap<String, OfPoint> = BTreeMap::new();
        let of = |numbers: &[f64]| numbers.get(3).copied().unwrap_or(0.0);
        let offset_sd = rows.first().map_or(0.0, |(_, _, numbers)| of(numbers));
        for (line, point, numbers) in rows {
            if of(&numbers) != offset_sd || !(0.0..=1e3).contains(&offset_sd) {
                let why = "offset_sd is of an error that all readings have in common: give it one number, from 0 to 1000, in all rows";
                return Err(at(path, line, why));
            }
            if !known(&point) {
                return Err(at(path, line, &format!("points.csv has no operating point `{point}`")));
            }
            let (place, value, sd) = (numbers[0], numbers[1], numbers[2]);
            let kind =
                if by_speed { SensorKind::SoundSpeed { place } } else { SensorKind::Temperature { place } };
            let [least, most] = kind.sds();
            if !(value.is_finite() && value > 0.0 && (least..most).contains(&sd)) {
                let why =
                    "the reading must be positive (temperatures in kelvin), and its sd from 0.001 to 1000";
                return Err(at(path, line, &format!("{value} +- {sd}: {why}")));
            }
            points.entry(point).or_default().push((kind, value, sd));
        }
        Ok(Self { points, offset_sd })
    }

    pub(crate) fn of(&self, point: &str) -> &[(SensorKind, f64, f64)] {
        self.points.get(point).map_or(&[], Vec::as_slice)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str, name: &str) -> Result<Readings, String> {
        let path = std::env::temp_dir().join(format!("rijke-readings-{}-{name}.csv", std::process::id()));
        std::fs::write(&path, text).unwrap();
        let found = Readings::read(&path, &|id| id.starts_with('H')).map_err(|e| e.to_string());
        std::fs::remove_file(&path).unwrap();
        found
    }

    #[test]
    fn exact_readings_are_read_and_bad_lines_named() {
        const HEAD: &str = "point,at [m],temperature [K],sd [K]\n";
        let good =
            read("point,at [mm],temperature [degC],sd [degC]\nH180-25, 500, 139.35, 1.5\n", "good").unwrap();
        assert_eq!(good.of("H180-25"), [(SensorKind::Temperature { place: 0.5 }, 412.5, 1.5)]);
        assert!(good.of("H7-25").is_empty());
        let good = read("point,at [m],sound_speed [m/s],sd [m/s]\nH180-25,0.7,401.0,0.8\n", "speed").unwrap();
        assert_eq!(good.of("H180-25"), [(SensorKind::SoundSpeed { place: 0.7 }, 401.0, 0.8)]);
        for (name, row, words) in [
            ("point", "X-25,0.5,400,1\n", "no operating point `X-25`"),
            ("celsius", "H7-25,0.5,-4,1\n", "line 2: -4 +- 1"),
            ("sd", "H7-25,0.5,300,0\n", "line 2: 300 +- 0"),
            ("text", "H7-25,middle,300,1\n", "line 2, column `at`"),
        ] {
            let word = read(&format!("{HEAD}{row}"), name).unwrap_err();
            assert!(word.contains(words) && word.contains("rijke-readings"), "{word}");
        }
        let offset = "point,at [m],temperature [degC],sd [K],offset_sd [K]\n";
        let row = "H180-25,0.5,139.35,1.5,3\n";
        assert_eq!(read(&format!("{offset}{row}{row}"), "offset").unwrap().offset_sd, 3.0);
        let word = read(&format!("{offset}{row}H180-25,0.6,120,1.5,2\n"), "offsets").unwrap_err();
        assert!(word.contains("line 3") && word.contains("one number"), "{word}");
        let both = "point,at [m],temperature [K],sound_speed [m/s],sd [K]\nH7-25,0.5,400,380,1\n";
        assert!(read(both, "both").unwrap_err().contains("sound_speed"));
    }
}
