//! Raw records: what a record is, what a set of records is, and where records come from.

use crate::files::in_range;
use crate::{Arrays, OperatingPoint, Problem, Rig, RigError};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// One record of all microphones.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Sampling rate, Hz.
    pub rate_hz: f64,
    /// The first `quiet` samples were taken before the loudspeaker acts: noise only. A click's trigger, t = 0, is
    /// at sample `quiet`. In a ping the recorder may skip from here to the last part of the forcing.
    pub quiet: usize,
    /// Largest pressure the instrument can record, Pa; infinite for floating-point files.
    pub full_scale: f64,
    /// Pressure in Pa: `channels[m]` belongs to microphone m of the rig; all of the same length.
    pub channels: Vec<Vec<f64>>,
}

/// Whether data come from a rig or from a computation. Every figure says which.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DataKind {
    /// From instruments.
    Measured,
    /// From the virtual laboratory.
    Virtual,
}

/// A day (or session) with one ambient state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Day {
    /// Name of the day.
    pub id: String,
    /// Ambient temperature, K.
    #[serde(rename = "ambient_temperature_k")]
    pub ambient_temperature: f64,
    /// Its standard deviation, K.
    #[serde(rename = "ambient_temperature_sd_k")]
    pub ambient_temperature_sd: f64,
}

/// How records of one kind are taken.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stretch {
    /// Sampling rate, Hz.
    pub rate_hz: f64,
    /// Samples before the loudspeaker acts; see [`Record::quiet`].
    #[serde(rename = "quiet_samples")]
    pub quiet: usize,
}

/// The records of one operating point.
#[derive(Clone, Debug, PartialEq)]
pub struct PointRecords {
    /// The operating point.
    pub point: OperatingPoint,
    /// Index into [`RecordSet::days`].
    pub day: usize,
    /// Files of the pings, relative to the set's folder; also the names by which rejections speak of them.
    pub pings: Vec<String>,
    /// Files of the clicks.
    pub clicks: Vec<String>,
}

/// Clicks in the empty tube at ambient temperature, from which channel delays are found.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// Index into [`RecordSet::days`].
    pub day: usize,
    /// How they were recorded.
    pub stretch: Stretch,
    /// Files of the clicks.
    pub clicks: Vec<String>,
}

/// Everything about a set of records but the samples.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordSet {
    /// The rig.
    pub rig: Rig,
    /// Measured or virtual.
    pub kind: DataKind,
    /// Who recorded it, when, where; appears in reports.
    pub source: String,
    /// For every channel of a file the microphone it records; none for a channel that is not a microphone.
    pub channels: Vec<Option<usize>>,
    /// Which arrays hold a record, in files that have named arrays.
    pub arrays: Arrays,
    /// Pressure of the largest integer of an integer file, Pa.
    pub full_scale: f64,
    /// How pings are taken.
    pub ping: Stretch,
    /// How clicks are taken.
    pub click: Stretch,
    /// The days.
    pub days: Vec<Day>,
    /// The records, operating point by operating point.
    pub points: Vec<PointRecords>,
    /// Calibration clicks, one entry per day and sampling rate.
    pub calibrations: Vec<Calibration>,
}

/// Where records come from: files of a real rig, or the virtual laboratory. Records are made or read one at a
/// time, so a set never has to fit into memory.
pub trait RecordSource: Sync {
    /// What the set holds.
    fn set(&self) -> &RecordSet;

    /// One ping: `point` indexes [`RecordSet::points`], `repeat` its pings.
    ///
    /// # Errors
    /// The record cannot be read or is not what the set says.
    fn ping(&self, point: usize, repeat: usize) -> Result<Record, RigError>;

    /// One click: `point` indexes [`RecordSet::points`], `repeat` its clicks.
    ///
    /// # Errors
    /// As [`RecordSource::ping`].
    fn click(&self, point: usize, repeat: usize) -> Result<Record, RigError>;

    /// One calibration click: `which` indexes [`RecordSet::calibrations`], `repeat` its clicks.
    ///
    /// # Errors
    /// As [`RecordSource::ping`].
    fn calibration(&self, which: usize, repeat: usize) -> Result<Record, RigError>;
}

impl Record {
    /// Number of samples per channel.
    #[must_use]
    pub fn len(&self) -> usize {
        self.channels.first().map_or(0, Vec::len)
    }

    /// Whether there are no samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of samples of channel `m` at the limit of the instrument.
    #[must_use]
    pub fn clipped(&self, m: usize) -> usize {
        let limit = self.full_scale * (1.0 - 1e-6);
        self.channels[m].iter().filter(|p| p.abs() >= limit).count()
    }
}

impl RecordSet {
    /// Checks that names resolve, ranges are sensible and every microphone has one channel.
    ///
    /// # Errors
    /// Key of the manifest, and the problem.
    pub fn validate(&self) -> Result<(), (String, Problem)> {
        let microphones = self.rig.microphones.positions.len();
        for &microphone in self.channels.iter().flatten() {
            if microphone >= microphones {
                let problem = Problem::NoSuchIndex { index: microphone, count: microphones };
                return Err(("channels".into(), problem));
            }
        }
        for microphone in 0..microphones {
            let count = self.channels.iter().filter(|c| **c == Some(microphone)).count();
            if count != 1 {
                return Err(("channels".into(), Problem::ChannelMap { microphone, count }));
            }
        }
        in_range("full_scale_pa", self.full_scale, 1e-9, 1e9, "Pa")?;
        if self.days.is_empty() {
            return Err(("day".into(), Problem::Empty { need: "one [[day]] with its ambient temperature" }));
        }
        for (k, day) in self.days.iter().enumerate() {
            let key = |name: &str| format!("day[{k}] `{}`: {name}", day.id);
            in_range(&key("ambient_temperature_k"), day.ambient_temperature, 150.0, 500.0, "K")?;
            in_range(&key("ambient_temperature_sd_k"), day.ambient_temperature_sd, 0.0, 50.0, "K")?;
        }
        distinct("day", self.days.iter().map(|day| day.id.as_str()))?;
        if self.points.is_empty() {
            return Err(("point".into(), Problem::Empty { need: "one [[point]] with its records" }));
        }
        distinct("point", self.points.iter().map(|p| p.point.id.as_str()))?;
        for entry in &self.points {
            let (key, length) = (format!("point `{}`", entry.point.id), self.rig.tube.length);
            if let Some(position) = entry.point.position
                && !(position > 0.0 && position < length)
            {
                return Err((key, Problem::OutsideTube { position, length }));
            }
            if entry.pings.is_empty() && entry.clicks.is_empty() {
                return Err((key, Problem::Empty { need: "one ping or one click" }));
            }
        }
        Ok(())
    }
}

/// No name twice.
fn distinct<'a>(place: &str, names: impl Iterator<Item = &'a str>) -> Result<(), (String, Problem)> {
    let mut seen = BTreeSet::new();
    for name in names {
        if !seen.insert(name) {
            return Err((place.to_owned(), Problem::Duplicate { name: name.to_owned() }));
        }
    }
    Ok(())
}
