//! What a set of records is, and where records come from.

use super::acquisition::Acquisition;
use super::reading::{Arrays, Reading};
use super::record::Record;
use crate::apparatus::geometry::Apparatus;
use crate::apparatus::point::OperatingPoint;
use crate::apparatus::way::Way;
use crate::error::RigError;
use crate::files::in_range;
use crate::problem::Problem;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

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

impl Day {
    /// Largest standard deviation of an ambient temperature, K.
    pub const LARGEST_SD: f64 = 50.0;
}

/// How records of one kind are taken.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RecordTiming {
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
    /// What sound passes there; if none, nothing but the duct, at ambient temperature.
    pub way: Option<Way>,
}

/// Clicks in the empty tube at ambient temperature, from which channel delays are found.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    /// Index into [`RecordSet::days`].
    pub day: usize,
    /// How they were recorded.
    pub stretch: RecordTiming,
    /// Files of the clicks.
    pub clicks: Vec<String>,
}

/// Everything about a set of records but the samples.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordSet {
    /// The rig.
    pub rig: Apparatus,
    /// Measured or virtual.
    pub kind: DataKind,
    /// Who recorded it, when, where; appears in reports.
    pub source: String,
    /// For every channel of a file the microphone it records; none for a channel that is not a microphone.
    pub channels: Vec<Option<usize>>,
    /// Which arrays hold a record, in files that have named arrays.
    pub arrays: Arrays,
    /// Pressure of the largest integer of an integer file, Pa, or its voltage, V
    /// ([`Reading::full_scale_in_volts`]); infinite if not stated.
    pub full_scale: f64,
    /// How pings are taken.
    pub ping: RecordTiming,
    /// How clicks are taken.
    pub click: RecordTiming,
    /// The days.
    pub days: Vec<Day>,
    /// The records, operating point by operating point.
    pub points: Vec<PointRecords>,
    /// Calibration clicks, one entry per day and sampling rate.
    pub calibrations: Vec<Calibration>,
    /// What else is known of files and channels.
    pub acquisition: Acquisition,
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

impl RecordSet {
    /// The operating point of which the file `name` is a ping or a click.
    #[must_use]
    pub fn point_of(&self, name: &str) -> Option<&str> {
        let has = |p: &&PointRecords| p.pings.iter().chain(&p.clicks).any(|file| file == name);
        self.points.iter().find(has).map(|p| p.point.id.as_str())
    }

    /// Checks that names resolve, ranges are sensible and every microphone has one channel.
    ///
    /// # Errors
    /// Key of the manifest, and the problem.
    pub fn validate(&self) -> Result<(), (String, Problem)> {
        let microphones = self.rig.microphones.positions.len();
        check_map(&self.channels, &self.acquisition.reading, microphones, "channels")?;
        for (k, exception) in self.acquisition.exceptions.iter().enumerate() {
            check_map(
                &exception.channels,
                &exception.reading,
                microphones,
                &format!("exception[{k}].channels"),
            )?;
            let microphone = self.rig.microphones.reference;
            if exception.reading.dead.contains(&microphone) {
                return Err((format!("exception[{k}].dead"), Problem::DeadReference { microphone }));
            }
        }
        if let Some(band) = self.acquisition.band_hz {
            for frequency in band {
                in_range("band_hz", frequency, 1e-3, 1e6, "Hz")?;
            }
            if band[0] >= band[1] {
                let what = "has the higher frequency first; write it as [low, high]";
                return Err(("band_hz".into(), Problem::Keys { what }));
            }
        }
        if let Some(mains_hz) = self.acquisition.mains_hz {
            in_range("mains_hz", mains_hz, 1.0, 1e3, "Hz")?;
        }
        self.listed_once()?;
        self.at_one_rate()?;
        if self.full_scale != f64::INFINITY {
            in_range("full_scale_pa", self.full_scale, 1e-9, 1e9, "Pa")?;
        }
        if self.days.is_empty() {
            return Err(("day".into(), Problem::Empty { need: "one [[day]] with its ambient temperature" }));
        }
        for (k, day) in self.days.iter().enumerate() {
            let key = |name: &str| format!("day[{k}] `{}`: {name}", day.id);
            in_range(&key("ambient_temperature_k"), day.ambient_temperature, 150.0, 500.0, "K")?;
            in_range(
                &key("ambient_temperature_sd_k"),
                day.ambient_temperature_sd,
                0.0,
                Day::LARGEST_SD,
                "K",
            )?;
        }
        distinct("day", self.days.iter().map(|day| day.id.as_str()))?;
        if self.points.is_empty() {
            return Err(("point".into(), Problem::Empty { need: "one [[point]] with its records" }));
        }
        distinct("point", self.points.iter().map(|p| p.point.id.as_str()))?;
        for entry in &self.points {
            let key = format!("point `{}`", entry.point.id);
            if let Some(way) = &entry.way {
                way.validate(&key, self.rig.duct.length)?;
            }
            if entry.pings.is_empty() && entry.clicks.is_empty() {
                return Err((key, Problem::Empty { need: "one ping or one click" }));
            }
        }
        Ok(())
    }
}

impl RecordSet {
    /// How a ping is taken: `point` indexes [`RecordSet::points`], `repeat` its pings.
    ///
    /// # Panics
    /// If there is no such ping.
    #[must_use]
    pub fn ping_timing(&self, point: usize, repeat: usize) -> RecordTiming {
        let (usual, records) = (self.ping, &self.points[point]);
        let exception = self.acquisition.exception(records.day, &records.pings[repeat]);
        let rate_hz = exception.and_then(|e| e.rate_hz).unwrap_or(usual.rate_hz);
        let as_long = (usual.quiet as f64 * rate_hz / usual.rate_hz).floor() as usize;
        RecordTiming { rate_hz, quiet: exception.and_then(|e| e.quiet).unwrap_or(as_long) }
    }

    /// The pings of a point are repeats of one measurement, and what they share is that of one sampling rate.
    fn at_one_rate(&self) -> Result<(), (String, Problem)> {
        for (k, entry) in self.points.iter().enumerate() {
            let rate = |n: usize| self.ping_timing(k, n).rate_hz;
            if let Some(n) = (1..entry.pings.len()).find(|n| rate(*n) != rate(0)) {
                let place = format!("point `{}`: pings[{n}] `{}`", entry.point.id, entry.pings[n]);
                let what = "has another sampling rate than the first ping of this point; make it a ping of a second operating point with the \
                            same factors, or correct `rate_hz` of its [[exception]]";
                return Err((place, Problem::Keys { what }));
            }
        }
        let exceptions = self.acquisition.exceptions.iter().enumerate();
        for (k, exception) in exceptions.filter(|(_, e)| e.rate_hz.is_some() || e.quiet.is_some()) {
            let clicks = self.points.iter().flat_map(|p| &p.clicks);
            let mut clicks = clicks.chain(self.calibrations.iter().flat_map(|c| &c.clicks));
            if let Some(click) = clicks.find(|click| exception.files.contains(*click)) {
                let what = "is a click, and `rate_hz` and `quiet_samples` of an [[exception]] are those of pings; clicks have those of [click], \
                            and each [[calibration]] its own";
                return Err((format!("exception[{k}].files `{click}`"), Problem::Keys { what }));
            }
        }
        Ok(())
    }

    /// A file that is listed twice would count as two repeats, or as two operating points.
    fn listed_once(&self) -> Result<(), (String, Problem)> {
        // A click of an empty tube may be one of a point and of a calibration.
        let mut seen: BTreeMap<String, String> = BTreeMap::new();
        for (k, entry) in self.calibrations.iter().enumerate() {
            for (n, file) in entry.clicks.iter().enumerate() {
                let place = format!("calibration[{k}]: clicks[{n}] `{file}`");
                if let Some(first) = seen.insert(plain(file), place.clone()) {
                    return Err((place, Problem::ListedTwice { first }));
                }
            }
        }
        seen.clear();
        for entry in &self.points {
            for (kind, files) in [("pings", &entry.pings), ("clicks", &entry.clicks)] {
                for (n, file) in files.iter().enumerate() {
                    let place = format!("point `{}`: {kind}[{n}] `{file}`", entry.point.id);
                    if let Some(first) = seen.insert(plain(file), place.clone()) {
                        return Err((place, Problem::ListedTwice { first }));
                    }
                }
            }
        }
        Ok(())
    }
}

/// A path without what changes nothing in it.
pub(crate) fn plain(name: &str) -> String {
    name.split('/').filter(|part| *part != ".").collect::<Vec<_>>().join("/")
}

/// Every microphone that is not dead has one channel.
pub(crate) fn check_map(
    channels: &[Option<usize>],
    reading: &Reading,
    microphones: usize,
    place: &str,
) -> Result<(), (String, Problem)> {
    let listed = || channels.iter().chain(reading.names.values()).flatten();
    if let Some(&index) = listed().find(|m| **m >= microphones) {
        return Err((place.into(), Problem::NoSuchIndex { index, count: microphones }));
    }
    for microphone in 0..microphones {
        let count = listed().filter(|m| **m == microphone).count();
        if count > 1 || count == 0 && !reading.dead.contains(&microphone) {
            return Err((place.into(), Problem::ChannelMap { microphone, count }));
        }
    }
    Ok(())
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
