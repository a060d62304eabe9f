//! A folder of records: `manifest.toml`, the rig, the campaign, and the files it lists.

use crate::files::{make_folder, parse_toml, read_text, write_toml, write_whole};
use crate::span::{Event, read_event};
use crate::wav::Layout;
use crate::{
    Arrays, Calibration, Campaign, DataKind, Day, PointRecords, Problem, Record, RecordSet, RecordSource,
    Rig, RigError, Stretch,
};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Records on disk, read one at a time.
#[derive(Clone, Debug)]
pub struct RecordFolder {
    folder: PathBuf,
    set: RecordSet,
}

/// `manifest.toml` as written.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Manifest {
    rig: String,
    campaign: String,
    kind: DataKind,
    source: String,
    full_scale_pa: f64,
    channels: Vec<i64>,
    #[serde(default, skip_serializing_if = "is_empty")]
    arrays: Arrays,
    ping: Stretch,
    click: Stretch,
    day: Vec<Day>,
    #[serde(default)]
    calibration: Vec<CalibrationEntry>,
    point: Vec<PointEntry>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct CalibrationEntry {
    day: String,
    rate_hz: f64,
    quiet_samples: usize,
    clicks: Vec<String>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PointEntry {
    id: String,
    day: String,
    #[serde(default)]
    pings: Vec<String>,
    #[serde(default)]
    clicks: Vec<String>,
}

/// Opening words of a manifest.
const HEADER: &str = "\
# A set of records. Paths are relative to this file. Each file (WAV, CSV, MATLAB, HDF5) holds all microphones of one record.
# channels: for every channel of a file, the microphone it records, counted from 0 along the tube; -1 for none.
# full_scale_pa: pressure of the largest integer of an integer WAV file (a float file and a CSV file are in Pa).
# quiet_samples: samples taken before the loudspeaker acts; the trigger of a click is at that sample.

";

impl RecordFolder {
    /// Opens a folder: reads its manifest, rig and campaign, and checks that every file exists. Samples are read
    /// later, record by record.
    ///
    /// # Errors
    /// The file, the place in it and the remedy.
    pub fn open(folder: &Path) -> Result<Self, RigError> {
        let path = folder.join("manifest.toml");
        if !path.is_file() {
            return Err(RigError::NotARecordSet { path });
        }
        let manifest: Manifest = parse_toml(&read_text(&path)?, &path)?;
        let rig = Rig::read(&folder.join(&manifest.rig))?;
        let campaign = Campaign::read(&folder.join(&manifest.campaign))?;
        let wrong = |(place, problem): (String, Problem)| RigError::invalid(&path, place, problem);
        let set = manifest.resolve(rig, &campaign).map_err(wrong)?;
        set.validate().map_err(wrong)?;
        let opened = Self { folder: folder.to_owned(), set };
        for file in opened.files() {
            let at = opened.folder.join(file);
            if !at.is_file() {
                return Err(RigError::invalid(&path, format!("`{file}`"), Problem::AbsentFile { path: at }));
            }
        }
        Ok(opened)
    }

    /// The folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Every file of the set, in order.
    fn files(&self) -> impl Iterator<Item = &String> {
        let points = self.set.points.iter().flat_map(|p| p.pings.iter().chain(&p.clicks));
        points.chain(self.set.calibrations.iter().flat_map(|c| &c.clicks))
    }

    fn read(&self, name: &str, stretch: Stretch, event: Event) -> Result<Record, RigError> {
        read_event(&self.folder.join(name), self.set.layout(stretch), event)
    }
}

impl RecordSource for RecordFolder {
    fn set(&self) -> &RecordSet {
        &self.set
    }

    fn ping(&self, point: usize, repeat: usize) -> Result<Record, RigError> {
        self.read(&self.set.points[point].pings[repeat], self.set.ping, Event::Ping)
    }

    fn click(&self, point: usize, repeat: usize) -> Result<Record, RigError> {
        self.read(&self.set.points[point].clicks[repeat], self.set.click, Event::Click)
    }

    fn calibration(&self, which: usize, repeat: usize) -> Result<Record, RigError> {
        let calibration = &self.set.calibrations[which];
        self.read(&calibration.clicks[repeat], calibration.stretch, Event::Click)
    }
}

impl RecordSet {
    /// How the files of one kind are to be read.
    #[must_use]
    pub fn layout(&self, stretch: Stretch) -> Layout<'_> {
        let Stretch { rate_hz, quiet } = stretch;
        Layout { channels: &self.channels, full_scale: self.full_scale, rate_hz, quiet, arrays: &self.arrays }
    }

    /// Writes `rig.toml`, `campaign.toml` and, last, `manifest.toml`: a folder whose records are incomplete has no
    /// manifest and is not taken for a record set.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), RigError> {
        make_folder(folder)?;
        write_toml(&self.rig, "# SI units; x = 0 is the bottom of the tube.\n\n", &folder.join("rig.toml"))?;
        let points = self.points.iter().map(|p| p.point.clone()).collect();
        let campaign = Campaign { name: self.source.clone(), points };
        write_whole(&folder.join("campaign.toml"), campaign.to_toml().as_bytes())?;
        write_toml(&Manifest::of(self), HEADER, &folder.join("manifest.toml"))
    }
}

impl Manifest {
    /// Replaces names by what they stand for.
    fn resolve(self, rig: Rig, campaign: &Campaign) -> Result<RecordSet, (String, Problem)> {
        let days: Vec<String> = self.day.iter().map(|day| day.id.clone()).collect();
        let day_index = |place: String, name: &str| {
            let known = || days.clone();
            days.iter().position(|id| id == name).ok_or_else(|| unknown(place, name, known()))
        };
        let mut points = Vec::with_capacity(self.point.len());
        for (k, entry) in self.point.into_iter().enumerate() {
            let known = || campaign.points.iter().map(|p| p.id.clone()).collect();
            let point = campaign.points.iter().find(|p| p.id == entry.id);
            let point = point.ok_or_else(|| unknown(format!("point[{k}].id"), &entry.id, known()))?.clone();
            let day = day_index(format!("point[{k}] `{}`: day", entry.id), &entry.day)?;
            points.push(PointRecords { point, day, pings: entry.pings, clicks: entry.clicks });
        }
        let mut calibrations = Vec::with_capacity(self.calibration.len());
        for (k, entry) in self.calibration.into_iter().enumerate() {
            let day = day_index(format!("calibration[{k}].day"), &entry.day)?;
            let stretch = Stretch { rate_hz: entry.rate_hz, quiet: entry.quiet_samples };
            calibrations.push(Calibration { day, stretch, clicks: entry.clicks });
        }
        Ok(RecordSet {
            rig,
            kind: self.kind,
            source: self.source,
            channels: self.channels.iter().map(|&m| usize::try_from(m).ok()).collect(),
            arrays: self.arrays,
            full_scale: self.full_scale_pa,
            ping: self.ping,
            click: self.click,
            days: self.day,
            points,
            calibrations,
        })
    }

    /// The manifest of a set.
    fn of(set: &RecordSet) -> Self {
        let day = |index: usize| set.days[index].id.clone();
        Self {
            rig: "rig.toml".into(),
            campaign: "campaign.toml".into(),
            kind: set.kind,
            source: set.source.clone(),
            arrays: set.arrays.clone(),
            full_scale_pa: set.full_scale,
            channels: set.channels.iter().map(|c| c.map_or(-1, |m| m as i64)).collect(),
            ping: set.ping,
            click: set.click,
            day: set.days.clone(),
            calibration: set
                .calibrations
                .iter()
                .map(|c| CalibrationEntry {
                    day: day(c.day),
                    rate_hz: c.stretch.rate_hz,
                    quiet_samples: c.stretch.quiet,
                    clicks: c.clicks.clone(),
                })
                .collect(),
            point: set
                .points
                .iter()
                .map(|p| PointEntry {
                    id: p.point.id.clone(),
                    day: day(p.day),
                    pings: p.pings.clone(),
                    clicks: p.clicks.clone(),
                })
                .collect(),
        }
    }
}

fn is_empty(arrays: &Arrays) -> bool {
    *arrays == Arrays::default()
}

fn unknown(place: String, name: &str, known: Vec<String>) -> (String, Problem) {
    (place, Problem::UnknownName { name: name.to_owned(), known })
}
