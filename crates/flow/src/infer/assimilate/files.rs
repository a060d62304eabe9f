//! Records on disk: `flow.toml` and one CSV of samples per heater position.

use super::record::{FlowRecord, Sample};
use crate::apparatus::folder::HeatedTube;
use crate::apparatus::geometry::TubeRig;
use crate::error::FlowError;
use crate::infer::sensor::{Sensor, SensorKind};
use crate::tube::pipe::Pipe;
use rijke_rig::DataKind;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A folder of records: the runs of one rig with the heater at different places.
#[derive(Clone, Debug)]
pub struct Records {
    /// Whether the data were measured.
    pub kind: DataKind,
    /// The rig.
    pub rig: TubeRig,
    /// Place of the heater, m, and what was recorded there.
    pub runs: Vec<(f64, FlowRecord)>,
}

/// `flow.toml`.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Manifest {
    kind: DataKind,
    /// File of the rig, relative to the folder.
    rig: String,
    interval_s: f64,
    ambient_sd_k: f64,
    ambient_drift_k_per_root_s: f64,
    power_sd: f64,
    sensors: Vec<Sensor>,
    runs: Vec<SettledRun>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SettledRun {
    heater_m: f64,
    samples: String,
}

impl Records {
    /// Reads `folder`/flow.toml and the files it names, and checks every run against the rig.
    ///
    /// # Errors
    /// [`FlowError::File`] with the file, the place and what to do; [`FlowError::InLine`] and
    /// [`FlowError::InRun`] with what is wrong in a line, or in the run.
    pub fn read(folder: &Path) -> Result<Self, FlowError> {
        let path = folder.join("flow.toml");
        let text = rijke_numerics::read_text(&path).map_err(|e| problem(&path, &e))?;
        let manifest: Manifest = toml::from_str(&text).map_err(|e| problem(&path, &e))?;
        let rig_path = folder.join(&manifest.rig);
        let rig = TubeRig::read(&rig_path).map_err(|e| problem(&rig_path, &e))?;
        if manifest.runs.is_empty() {
            return Err(problem(&path, &"it lists no runs; add a [[runs]] table with heater_m and samples"));
        }
        let mut runs = Vec::with_capacity(manifest.runs.len());
        for run in &manifest.runs {
            let file = folder.join(&run.samples);
            let record = FlowRecord {
                interval: manifest.interval_s,
                sensors: manifest.sensors.clone(),
                ambient_sd: manifest.ambient_sd_k,
                ambient_drift: manifest.ambient_drift_k_per_root_s,
                power_sd: manifest.power_sd,
                samples: samples(&file, &manifest.sensors)?,
            };
            // The first line holds the names of the columns.
            let in_run = |error: FlowError| match error {
                FlowError::Sample { index, source } => {
                    FlowError::InLine { file: file.clone(), line: index + 2, source }
                }
                FlowError::Readings { index, .. } => {
                    FlowError::InLine { file: file.clone(), line: index + 2, source: Box::new(error) }
                }
                FlowError::Setting { .. } => FlowError::InRun { file: path.clone(), source: Box::new(error) },
                _ => FlowError::InRun { file: file.clone(), source: Box::new(error) },
            };
            let pipe = Pipe::new(&rig, &crate::tube::closures::Closures::default(), run.heater_m, 1)
                .map_err(in_run)?;
            runs.push((run.heater_m, record.checked(&pipe).map_err(in_run)?));
        }
        Ok(Self { kind: manifest.kind, rig, runs })
    }

    /// Writes the folder that [`Records::read`] reads. All runs must have the sensors of the first.
    ///
    /// # Errors
    /// [`FlowError::File`].
    pub fn write(&self, folder: &Path) -> Result<(), FlowError> {
        let Some((_, first)) = self.runs.first() else { return Ok(()) };
        let name = |heater: f64| format!("heater-{:03.0}mm.csv", heater * 1e3);
        let manifest = Manifest {
            kind: self.kind,
            rig: HeatedTube::FILE.into(),
            interval_s: first.interval,
            ambient_sd_k: first.ambient_sd,
            ambient_drift_k_per_root_s: first.ambient_drift,
            power_sd: first.power_sd,
            sensors: first.sensors.clone(),
            runs: self.runs.iter().map(|(x, _)| SettledRun { heater_m: *x, samples: name(*x) }).collect(),
        };
        write(&folder.join("flow.toml"), &manifest)?;
        write(&folder.join(HeatedTube::FILE), &self.rig)?;
        for (heater, record) in &self.runs {
            let path = folder.join(name(*heater));
            let mut file = csv::Writer::from_path(&path).map_err(|e| problem(&path, &e))?;
            file.write_record(header(&record.sensors)).map_err(|e| problem(&path, &e))?;
            for sample in &record.samples {
                let row = [sample.power, sample.ambient].into_iter().chain(sample.readings.iter().copied());
                file.write_record(row.map(|v| v.to_string())).map_err(|e| problem(&path, &e))?;
            }
            file.flush().map_err(|e| problem(&path, &e))?;
        }
        Ok(())
    }
}

fn write(path: &Path, value: &impl Serialize) -> Result<(), FlowError> {
    let text = toml::to_string(value).map_err(|e| problem(path, &e))?;
    std::fs::write(path, text).map_err(|e| problem(path, &e))
}

fn problem(path: &Path, why: &impl ToString) -> FlowError {
    // Some errors name the file themselves, and the line behind a colon.
    let (file, why) = (path.display().to_string(), why.to_string());
    let place = why.strip_prefix(&file).and_then(|rest| rest.strip_prefix(':'));
    let problem = place.map_or(why.as_str(), str::trim_start).to_owned();
    FlowError::File { file: path.to_path_buf(), problem }
}

/// `power_w`, `ambient_k`, then one column per sensor with its unit.
fn header(sensors: &[Sensor]) -> Vec<String> {
    let name = |s: &Sensor| match s.kind {
        SensorKind::Arrival { microphone } => format!("arrival_{microphone}_s"),
        SensorKind::Temperature { place } => format!("temperature_{place}_k"),
        SensorKind::SoundSpeed { place } => format!("sound_speed_{place}_m_per_s"),
    };
    ["power_w".to_string(), "ambient_k".to_string()].into_iter().chain(sensors.iter().map(name)).collect()
}

fn samples(path: &Path, sensors: &[Sensor]) -> Result<Vec<Sample>, FlowError> {
    let text = rijke_numerics::read_text(path).map_err(|e| problem(path, &e))?;
    let mut file = csv::Reader::from_reader(text.as_bytes());
    let expected = header(sensors);
    let found: Vec<String> =
        file.headers().map_err(|e| problem(path, &e))?.iter().map(str::to_string).collect();
    if found != expected {
        let why = format!("its columns are {}; flow.toml asks for {}", found.join(", "), expected.join(", "));
        return Err(problem(path, &why));
    }
    let mut samples = Vec::new();
    for (index, row) in file.records().enumerate() {
        let row = row.map_err(|e| problem(path, &e))?;
        let number = |(column, text): (usize, &str)| {
            text.trim().parse::<f64>().map_err(|_| {
                problem(
                    path,
                    &format!("line {}, column {}: `{text}` is not a number", index + 2, expected[column]),
                )
            })
        };
        let values = row.iter().enumerate().map(number).collect::<Result<Vec<f64>, _>>()?;
        samples.push(Sample { power: values[0], ambient: values[1], readings: values[2..].to_vec() });
    }
    Ok(samples)
}
