//! Records that are still being made: which of the files that a manifest lists are there, whole and readable.

use super::folder::digest;
use crate::{Described, RecordFolder, RecordSource, RigError};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// A folder of records that is looked at again and again while it fills.
#[derive(Debug)]
pub struct Arrivals {
    folder: PathBuf,
    described: Described,
    manifest: Option<(Stamp, RecordFolder)>,
    /// What was wrong with the manifest at the last look.
    fault: Option<String>,
    files: BTreeMap<String, State>,
}

/// What one look found.
#[derive(Clone, Debug)]
pub struct Arrived {
    /// The records that are whole; none before there is a manifest with one of them.
    pub records: Option<RecordFolder>,
    /// Files that came, changed or went since the last look.
    pub changed: Vec<String>,
    /// Files that cannot be read, with the reason, and what is wrong with the manifest.
    pub unusable: BTreeMap<String, String>,
    /// How many of these are copies of files that count: no better file will come.
    pub copies: usize,
    /// Files that are listed and not there, or still growing.
    pub awaited: usize,
    /// Files that are whole.
    pub whole: usize,
}

/// A file is the same as long as its length and the time of its last change are.
type Stamp = (u64, Option<SystemTime>);

#[derive(Clone, Debug)]
enum State {
    /// Seen once: it may still be written.
    Growing(Stamp),
    /// Read, and right; with a hash of its bytes.
    Whole(Stamp, u64),
    /// Read, and wrong.
    Unusable(Stamp, String),
    /// A copy of a file that counts.
    Copy(Stamp, String),
}

impl Arrivals {
    /// Of a folder that may still be empty; `described` as in [`RecordFolder::open_of`].
    #[must_use]
    pub fn new(folder: &Path, described: Described) -> Self {
        Self { folder: folder.to_owned(), described, manifest: None, fault: None, files: BTreeMap::new() }
    }

    /// Looks again. A file counts once two looks in turn found it the same and it could be read as what the
    /// manifest says.
    pub fn look(&mut self) -> Arrived {
        let path = self.folder.join("manifest.toml");
        let mut changed = Vec::new();
        if let Some(stamp) = stamp(&path)
            && self.manifest.as_ref().is_none_or(|(known, _)| *known != stamp)
        {
            match RecordFolder::expected(&self.folder, self.described.clone()) {
                Ok(records) => {
                    // Another manifest may say other things of the same files.
                    if let Some((_, old)) = &self.manifest {
                        let (then, now) = (said_of(old), said_of(&records));
                        let same = |file: &String| then.get(file) == now.get(file);
                        let files = std::mem::take(&mut self.files).into_iter();
                        let (same, other): (BTreeMap<_, _>, _) = files.partition(|(file, _)| same(file));
                        self.files = same;
                        changed.extend(BTreeMap::into_keys(other));
                    }
                    (self.manifest, self.fault) = (Some((stamp, records)), None);
                }
                Err(error) => self.fault = Some(error.to_string()),
            }
        }
        let mut look = Arrived {
            records: None,
            changed,
            unusable: self.fault.iter().map(|f| ("manifest.toml".to_owned(), f.clone())).collect(),
            copies: 0,
            awaited: 0,
            whole: 0,
        };
        let Some((_, records)) = &self.manifest else { return look };
        let mut states = BTreeMap::new();
        for item in records.set().items() {
            let file = item.name(records.set());
            let path = self.folder.join(file);
            let once = || -> Result<u64, RigError> {
                item.read(records)?;
                digest(&path).map_err(RigError::read(&path))
            };
            let before = self.files.remove(file);
            let counted = matches!(before, Some(State::Whole(..)));
            let Some(now) = stamp(&path) else {
                look.awaited += 1;
                look.changed.extend(counted.then(|| file.to_owned()));
                continue;
            };
            let state = match before {
                Some(State::Whole(then, hash)) if then == now => State::Whole(now, hash),
                Some(State::Unusable(then, why)) if then == now => State::Unusable(now, why),
                Some(State::Copy(then, why)) if then == now => State::Copy(now, why),
                Some(State::Growing(then)) if then == now => match once() {
                    Ok(hash) => match self.twin(&states, file, hash) {
                        Some(twin) => State::Copy(
                            now,
                            format!(
                                "holds the same bytes as {twin}, of which it is a copy, and does not count; give the file that belongs here"
                            ),
                        ),
                        None => {
                            look.changed.push(file.to_owned());
                            State::Whole(now, hash)
                        }
                    },
                    Err(error) => State::Unusable(now, error.to_string()),
                },
                _ => {
                    look.changed.extend(counted.then(|| file.to_owned()));
                    State::Growing(now)
                }
            };
            match &state {
                State::Growing(_) => look.awaited += 1,
                State::Whole(..) => look.whole += 1,
                State::Unusable(_, why) | State::Copy(_, why) => {
                    look.unusable.insert(file.to_owned(), why.clone());
                    look.copies += usize::from(matches!(state, State::Copy(..)));
                }
            }
            states.insert(file.to_owned(), state);
        }
        // What is listed no longer.
        let gone = std::mem::replace(&mut self.files, states).into_iter();
        look.changed.extend(gone.filter(|(_, s)| matches!(s, State::Whole(..))).map(|(file, _)| file));
        let whole = |file: &str| matches!(self.files.get(file), Some(State::Whole(..)));
        look.records = (look.whole > 0).then(|| records.restricted(whole));
        look
    }

    /// A file that counts and holds the same bytes: of those looked at before this one, `before`, and after
    /// it.
    fn twin(&self, before: &BTreeMap<String, State>, file: &str, hash: u64) -> Option<String> {
        let same = |(name, state): (&String, &State)| {
            let alike = matches!(state, State::Whole(_, other) if *other == hash);
            let bytes = |name: &str| fs::read(self.folder.join(name)).ok();
            (alike && bytes(name) == bytes(file)).then(|| name.clone())
        };
        before.iter().chain(&self.files).find_map(same)
    }
}

fn stamp(path: &Path) -> Option<Stamp> {
    let found = fs::metadata(path).ok().filter(fs::Metadata::is_file)?;
    Some((found.len(), found.modified().ok()))
}

/// All that a manifest says of each of its files.
fn said_of(records: &RecordFolder) -> BTreeMap<String, String> {
    let set = records.set();
    let of_all = format!(
        "{:?} {:?} {:?} {:?} {:?} {:?} {:?}",
        set.channels, set.arrays, set.full_scale, set.ping, set.click, set.acquisition, set.rig
    );
    let of_points = set.points.iter().flat_map(|p| {
        let said = format!("{:?} {:?} {:?} {of_all}", p.point, p.way, set.days[p.day]);
        p.pings.iter().chain(&p.clicks).map(move |file| (file.clone(), said.clone()))
    });
    let of_calibrations = set.calibrations.iter().flat_map(|c| {
        let said = format!("{:?} {:?} {of_all}", c.stretch, set.days[c.day]);
        c.clicks.iter().map(move |file| (file.clone(), said.clone()))
    });
    of_points.chain(of_calibrations).collect()
}
