//! Readings of thermometers or of the speed of sound along the tube, for users without clicks.

use crate::error::FlowError;
use crate::infer::sensor::SensorKind;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;

/// Readings of one operating point.
pub(crate) type OfPoint = Vec<(SensorKind, f64, f64)>;

/// Readings along the tube by operating point: `readings.csv` beside the observations.
///
/// One row per reading, with the columns `point`, `place_m`, `temperature_k`, `sound_speed_m_per_s` and `sd`;
/// one of the two quantities is given and the other left empty, and `sd` (K or m/s) is the standard deviation
/// of that reading, errors of calibration included.
#[derive(Clone, Debug, Default)]
pub struct Readings {
    pub(crate) points: BTreeMap<String, OfPoint>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    point: String,
    place_m: f64,
    temperature_k: Option<f64>,
    sound_speed_m_per_s: Option<f64>,
    sd: f64,
}

impl Readings {
    /// Name of the file in a folder of observations.
    pub const FILE: &'static str = "readings.csv";

    /// Reads the file; `known` says whether an operating point exists.
    ///
    /// # Errors
    /// [`FlowError::File`] with the line and what is wrong in it.
    pub fn read(path: &Path, known: &dyn Fn(&str) -> bool) -> Result<Self, FlowError> {
        let problem = |problem: String| FlowError::File { file: path.to_path_buf(), problem };
        let text = rijke_numerics::read_text(path).map_err(|e| problem(e.to_string()))?;
        let mut file = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
        let mut points: BTreeMap<String, OfPoint> = BTreeMap::new();
        for (index, row) in file.deserialize::<Row>().enumerate() {
            let line = index + 2;
            let row = row.map_err(|e| problem(e.to_string()))?;
            if !known(&row.point) {
                let why = format!("line {line}: points.csv has no operating point `{}`", row.point);
                return Err(problem(why));
            }
            let place = row.place_m;
            let (kind, value) = match (row.temperature_k, row.sound_speed_m_per_s) {
                (Some(value), None) => (SensorKind::Temperature { place }, value),
                (None, Some(value)) => (SensorKind::SoundSpeed { place }, value),
                _ => {
                    let why = "give either temperature_k or sound_speed_m_per_s, and leave the other empty";
                    return Err(problem(format!("line {line}: {why}")));
                }
            };
            let positive = |v: f64| v.is_finite() && v > 0.0;
            let [least, most] = kind.sds();
            if !positive(value) || !(least..most).contains(&row.sd) {
                let why =
                    "the reading must be positive (temperatures in kelvin), and its sd from 0.001 to 1000";
                return Err(problem(format!("line {line}: {value} +- {}: {why}", row.sd)));
            }
            points.entry(row.point).or_default().push((kind, value, row.sd));
        }
        Ok(Self { points })
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
        const HEAD: &str = "point,place_m,temperature_k,sound_speed_m_per_s,sd\n";
        let good =
            read(&format!("{HEAD}H180-25, 0.5, 412.5, , 1.5\nH180-25,0.7,,401.0,0.8\n"), "good").unwrap();
        let expected = [
            (SensorKind::Temperature { place: 0.5 }, 412.5, 1.5),
            (SensorKind::SoundSpeed { place: 0.7 }, 401.0, 0.8),
        ];
        assert_eq!(good.of("H180-25"), expected);
        assert!(good.of("H7-25").is_empty());
        for (name, row, words) in [
            ("point", "X-25,0.5,400,,1\n", "no operating point `X-25`"),
            ("both", "H7-25,0.5,400,380,1\n", "line 2: give either"),
            ("celsius", "H7-25,0.5,-4,,1\n", "line 2: -4 +- 1"),
            ("sd", "H7-25,0.5,300,,0\n", "line 2: 300 +- 0"),
            ("text", "H7-25,middle,300,,1\n", "invalid float"),
        ] {
            let word = read(&format!("{HEAD}{row}"), name).unwrap_err();
            assert!(word.contains(words) && word.contains("rijke-readings"), "{word}");
        }
    }
}
