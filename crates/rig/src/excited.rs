//! Records of a rig that random noise drives, a sweep, a periodic sound, or a blow: a folder with a
//! `manifest.toml` that has `[random]`, `[sweep]` or `[blow]`.

use crate::driven::{Driven, DrivenKeys, driven};
use crate::files::{parse_toml, read_text};
use crate::manifest::MicrophoneKeys;
use crate::{Arrays, DataKind, Elsewhere, Layout, Problem, Reading, Record, RigError, inspect, read_record};
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// Such a folder: what its manifest says. Every channel of a file is a microphone, in the order of the rig.
#[derive(Clone, Debug, PartialEq)]
pub struct ExcitedRecords {
    /// The manifest.
    pub path: PathBuf,
    /// Measured or virtual.
    pub kind: DataKind,
    /// Who, when, where.
    pub source: String,
    /// Sampling rate, Hz.
    pub rate_hz: f64,
    /// Frequencies that are wanted, Hz.
    pub band_hz: [f64; 2],
    /// What drives the rig.
    pub excitation: Excitation,
    /// Where the files are.
    folder: PathBuf,
}

/// What drives a rig.
#[derive(Clone, Debug, PartialEq)]
pub enum Excitation {
    /// Steady random noise, a sweep, or a periodic sound.
    Driven(Box<Driven>),
    /// A blow at the beginning of every record.
    Blow(Blow),
}

/// Records of a blow.
#[derive(Clone, Debug, PartialEq)]
pub struct Blow {
    /// The stretch that is used, s after the onset of the blow.
    pub stretch: [f64; 2],
    /// The records.
    pub files: Vec<String>,
    /// The states of the rig that sound in one record.
    pub states: Vec<BlowState>,
}

/// A state of a rig, by its modes.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BlowState {
    /// The operating point that has this state.
    pub point: String,
    /// About where its modes are, Hz.
    pub near_hz: Vec<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Manifest {
    kind: DataKind,
    source: String,
    rate_hz: f64,
    band_hz: [f64; 2],
    measured: Option<Elsewhere>,
    random: Option<DrivenKeys>,
    sweep: Option<DrivenKeys>,
    microphones: Option<MicrophoneKeys>,
    blow: Option<BlowKeys>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BlowKeys {
    /// From and to, s after the onset.
    stretch_s: [f64; 2],
    files: Vec<String>,
    state: Vec<BlowState>,
}

impl ExcitedRecords {
    /// Opens a folder; none if its manifest is one of pings and clicks, or absent.
    ///
    /// # Errors
    /// File, place and remedy; [`RigError::Elsewhere`] if the data are other people's and not here.
    pub fn open(folder: &Path) -> Result<Option<Self>, RigError> {
        let path = folder.join("manifest.toml");
        if !path.is_file() {
            return Ok(None);
        }
        let text = read_text(&path)?;
        let keys: toml::Table = parse_toml(&text, &path)?;
        if !["random", "sweep", "blow"].iter().any(|key| keys.contains_key(*key)) {
            return Ok(None);
        }
        let manifest: Manifest = parse_toml(&text, &path)?;
        let wrong = |place: &str, what| Err(RigError::invalid(&path, place, Problem::Keys { what }));
        let [low, high] = manifest.band_hz;
        if !(manifest.rate_hz > 0.0 && low > 0.0 && low < high && high < 0.5 * manifest.rate_hz) {
            return wrong(
                "`rate_hz`, `band_hz`",
                "must be above zero, and the band ascend below half the rate",
            );
        }
        let excitation = match (manifest.random, manifest.sweep, manifest.blow) {
            (Some(random), None, None) => {
                Excitation::Driven(Box::new(driven(random, "[random]", manifest.microphones, &path)?))
            }
            (None, Some(sweep), None) => {
                Excitation::Driven(Box::new(driven(sweep, "[sweep]", manifest.microphones, &path)?))
            }
            (None, None, Some(blow)) => {
                let stretch = blow.stretch_s;
                if !(0.0 <= stretch[0] && stretch[0] < stretch[1])
                    || blow.files.is_empty()
                    || blow.state.is_empty()
                {
                    return wrong(
                        "[blow]",
                        "must have a stretch_s that ascends from 0 or more, files, and a [[blow.state]]",
                    );
                }
                if manifest.microphones.is_some() {
                    return wrong(
                        "[microphones]",
                        "has no meaning for a blow, whose modes need no gains; leave it out",
                    );
                }
                let within = |f: &f64| 0.5 * low <= *f && *f <= high;
                if !blow.state.iter().flat_map(|s| &s.near_hz).all(within) {
                    return wrong("[[blow.state]]", "must have a near_hz within `band_hz`");
                }
                Excitation::Blow(Blow { stretch, files: blow.files, states: blow.state })
            }
            _ => {
                return wrong(
                    "[random], [sweep], [blow]",
                    "exclude each other; put the records into folders of their own",
                );
            }
        };
        let folder = match &manifest.measured {
            None => folder.to_owned(),
            Some(elsewhere) => elsewhere
                .find()
                .ok_or_else(|| RigError::Elsewhere { path: path.clone(), data: elsewhere.clone() })?,
        };
        let Manifest { kind, source, rate_hz, band_hz, .. } = manifest;
        Ok(Some(Self { path, kind, source, rate_hz, band_hz, excitation, folder }))
    }

    /// Reads one record. Integers are parts of full scale, floats as they are.
    ///
    /// # Errors
    /// As [`read_record`]; another number of channels than `channels`, if that is stated.
    pub fn read(&self, file: &str, channels: Option<usize>) -> Result<Record, RigError> {
        let path = self.folder.join(file);
        let channels = channels.map_or_else(|| inspect(&path).map(|found| found.channels.len()), Ok)?;
        let all: Vec<Option<usize>> = (0..channels).map(Some).collect();
        let layout = Layout {
            channels: &all,
            full_scale: 1.0,
            rate_hz: self.rate_hz,
            quiet: 0,
            arrays: &Arrays::default(),
            reading: &Reading::default(),
        };
        read_record(&path, layout)
    }
}
