//! A folder of records: `manifest.toml`, the rig, the campaign, and the files it lists.

use super::keys::{HEADER, Manifest};
use crate::apparatus::geometry::Apparatus;
use crate::apparatus::point::OperatingPoint;
use crate::apparatus::way::Way;
use crate::error::RigError;
use crate::files::{make_folder, parse_toml, read_text, write_toml};
use crate::observations::row::read_points;
use crate::observations::table::{APPARATUS, write_points};
use crate::problem::Problem;
use crate::read::layout::Layout;
use crate::read::span::{Event, read_event};
use crate::records::record::Record;
use crate::records::set::{RecordSet, RecordSource, RecordTiming};
use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hasher};
use std::io::Read;
use std::path::{Path, PathBuf};

/// What is known of records from elsewhere, where their manifest does not name files for it.
#[derive(Clone, Debug, Default)]
pub struct Described {
    /// The rig.
    pub rig: Option<Apparatus>,
    /// The operating points.
    pub points: Option<Vec<OperatingPoint>>,
}

/// Records on disk, read one at a time.
#[derive(Clone, Debug)]
pub struct RecordFolder {
    folder: PathBuf,
    set: RecordSet,
    own_campaign: bool,
}

impl RecordFolder {
    /// Opens a folder: reads its manifest, rig and campaign, and checks that every file exists. Samples are
    /// read later, record by record.
    ///
    /// # Errors
    /// The file, the place in it and the remedy.
    pub fn open(folder: &Path) -> Result<Self, RigError> {
        Self::open_of(folder, Described::default())
    }

    /// As [`RecordFolder::open`], for records of a rig and a campaign that are described elsewhere; a
    /// manifest that names files of its own for them counts first.
    ///
    /// # Errors
    /// As [`RecordFolder::open`].
    pub fn open_of(folder: &Path, described: Described) -> Result<Self, RigError> {
        let opened = Self::expected(folder, described)?;
        for file in opened.set.items().into_iter().map(|item| item.name(&opened.set)) {
            let at = opened.folder.join(file);
            if !at.is_file() {
                let manifest = folder.join("manifest.toml");
                return Err(RigError::invalid(
                    &manifest,
                    format!("`{file}`"),
                    Problem::AbsentFile { path: at },
                ));
            }
        }
        Ok(opened)
    }

    /// As [`RecordFolder::open_of`], of records that are still being made: files may be absent. Only those
    /// are read that [`RecordFolder::restricted`] leaves.
    ///
    /// # Errors
    /// Those of the manifest.
    pub fn expected(folder: &Path, described: Described) -> Result<Self, RigError> {
        let path = folder.join("manifest.toml");
        if !path.exists() {
            return Err(RigError::NotARecordSet { path });
        }
        let manifest: Manifest = parse_toml(&read_text(&path)?, &path)?;
        let own_campaign = manifest.campaign.is_some();
        let rig = match &manifest.rig {
            Some(file) => Some(Apparatus::read(&folder.join(file))?),
            None => described.rig,
        };
        let points = match &manifest.campaign {
            Some(file) => Some(read_points(&folder.join(file))?),
            None => described.points,
        };
        let (Some(rig), Some(points)) = (rig, points) else {
            let what = "are missing; name the files, or leave both out where the records lie in the folder of a study";
            return Err(RigError::invalid(&path, "`rig` and `campaign`", Problem::Keys { what }));
        };
        let wrong = |(place, problem): (String, Problem)| RigError::invalid(&path, place, problem);
        let channels = super::microphones::Channels::read(
            &manifest.microphones,
            rig.microphones.positions.len(),
            &manifest.dead,
            &path,
        )?;
        let set = manifest.resolve(rig, &points, channels).map_err(wrong)?;
        set.validate().map_err(wrong)?;
        Ok(Self { folder: folder.to_owned(), set, own_campaign })
    }

    /// The set with the files for which `there` holds, and without points and calibrations that have none.
    #[must_use]
    pub fn restricted(&self, there: impl Fn(&str) -> bool) -> Self {
        let mut set = self.set.clone();
        let keep = |files: &mut Vec<String>| files.retain(|file| there(file));
        for point in &mut set.points {
            keep(&mut point.pings);
            keep(&mut point.clicks);
        }
        set.points.retain(|p| !p.pings.is_empty() || !p.clicks.is_empty());
        set.calibrations.iter_mut().for_each(|c| keep(&mut c.clicks));
        set.calibrations.retain(|c| !c.clicks.is_empty());
        Self { set, ..self.clone() }
    }

    /// Says what the microphones of the rig as it stands are called, so that names of columns are compared.
    pub fn name_microphones(&mut self, names: &[String]) {
        let acquisition = &mut self.set.acquisition;
        let numbers = acquisition.numbers(self.set.rig.microphones.positions.len());
        let names: Vec<String> = numbers.iter().filter_map(|n| names.get(*n).cloned()).collect();
        let exceptions = acquisition.exceptions.iter_mut().map(|e| &mut e.reading);
        exceptions.chain([&mut acquisition.reading]).for_each(|r| r.microphones.clone_from(&names));
    }

    /// Says what sound passes at the points of which the manifest does not.
    pub fn fill_ways(&mut self, way: impl Fn(&OperatingPoint) -> Option<Way>) {
        for entry in self.set.points.iter_mut().filter(|entry| entry.way.is_none()) {
            entry.way = way(&entry.point);
        }
    }

    /// The folder.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Whether the manifest names a campaign of its own.
    #[must_use]
    pub fn has_own_campaign(&self) -> bool {
        self.own_campaign
    }

    /// Pairs of records that hold the same bytes, the earlier first: one that was copied under another name
    /// counts twice.
    ///
    /// # Errors
    /// A file cannot be read.
    pub fn twins(&self) -> Result<Vec<(String, String)>, RigError> {
        let mut by_size: BTreeMap<u64, Vec<&str>> = BTreeMap::new();
        for file in self.set.items().into_iter().map(|item| item.name(&self.set)) {
            let path = self.folder.join(file);
            let size = std::fs::metadata(&path).map_err(RigError::read(&path))?.len();
            by_size.entry(size).or_default().push(file);
        }
        let mut twins = Vec::new();
        for files in by_size.values().filter(|files| files.len() > 1) {
            let mut seen: BTreeMap<u64, &str> = BTreeMap::new();
            for file in files {
                let path = self.folder.join(file);
                let digest = digest(&path).map_err(RigError::read(&path))?;
                match seen.get(&digest) {
                    Some(first) if *first != *file => twins.push(((*first).to_owned(), (*file).to_owned())),
                    Some(_) => {}
                    None => drop(seen.insert(digest, file)),
                }
            }
        }
        Ok(twins)
    }

    fn read(&self, name: &str, day: usize, stretch: RecordTiming, event: Event) -> Result<Record, RigError> {
        let path = self.folder.join(name);
        let layout = self.set.layout(stretch);
        let layout = match self.set.acquisition.exception(day, name) {
            Some(exception) => {
                Layout { channels: &exception.channels, reading: &exception.reading, ..layout }
            }
            None => layout,
        };
        read_event(&path, layout, event)
    }
}

/// A number that differs for files that differ, but for one pair in 1e19.
pub(super) fn digest(path: &Path) -> std::io::Result<u64> {
    let mut file = rijke_numerics::open_file(path)?;
    let (mut hasher, mut block) = (DefaultHasher::new(), vec![0; 1 << 16]);
    loop {
        match file.read(&mut block)? {
            0 => return Ok(hasher.finish()),
            n => hasher.write(&block[..n]),
        }
    }
}

impl RecordSource for RecordFolder {
    fn set(&self) -> &RecordSet {
        &self.set
    }

    fn ping(&self, point: usize, repeat: usize) -> Result<Record, RigError> {
        let records = &self.set.points[point];
        self.read(&records.pings[repeat], records.day, self.set.ping_timing(point, repeat), Event::Ping)
    }

    fn click(&self, point: usize, repeat: usize) -> Result<Record, RigError> {
        let records = &self.set.points[point];
        self.read(&records.clicks[repeat], records.day, self.set.click, Event::Click)
    }

    fn calibration(&self, which: usize, repeat: usize) -> Result<Record, RigError> {
        let calibration = &self.set.calibrations[which];
        self.read(&calibration.clicks[repeat], calibration.day, calibration.stretch, Event::Click)
    }
}

impl RecordSet {
    /// How the files of one kind are to be read.
    #[must_use]
    pub fn layout(&self, stretch: RecordTiming) -> Layout<'_> {
        let RecordTiming { rate_hz, quiet } = stretch;
        let Self { channels, arrays, full_scale, .. } = self;
        let reading = &self.acquisition.reading;
        Layout { channels, full_scale: *full_scale, rate_hz, quiet, arrays, reading }
    }

    /// Writes `rig.toml`, `campaign.csv` and, last, `manifest.toml`: a folder whose records are incomplete
    /// has no manifest and is not taken for a record set.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), RigError> {
        make_folder(folder)?;
        write_toml(&self.rig, APPARATUS, &folder.join(Apparatus::FILE))?;
        write_points(self.points.iter().map(|p| &p.point), &folder.join("campaign.csv"))?;
        write_toml(&Manifest::of(self), HEADER, &folder.join("manifest.toml"))
    }
}
