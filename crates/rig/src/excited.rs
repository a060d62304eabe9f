//! Records of a rig that random noise drives, a sweep, a periodic sound, or a blow, and of microphones that
//! are compared: a folder with a `manifest.toml` that has `[random]`, `[sweep]`, `[blow]` or `[comparison]`.

use crate::driven::{Driven, DrivenKeys, driven};
use crate::files::{in_range, parse_toml, read_text};
use crate::manifest::{Channels, Listed, MicrophoneKeys, full_scale};
use crate::records::set::plain;
use crate::units::Given;
use crate::{
    Arrays, ChannelContents, DataKind, Elsewhere, Layout, Problem, Reading, Record, RigError, inspect,
    read_record,
};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Such a folder: what its manifest says. Every channel of a file is a microphone, in the order of the rig,
/// unless the manifest lists them.
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
    /// Which channel of a file is which microphone; none if all are, in the order of the rig.
    channels: Option<Listed>,
    /// Largest integer of a file, and whether it is in V; 1 Pa if not stated.
    full_scale: (f64, bool),
    /// Which arrays of a file hold the record.
    arrays: Arrays,
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
    /// Noise that all microphones hear alike.
    Comparison(Box<Comparison>),
}

/// Records in which all microphones hear the same pressure.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// The records.
    pub files: Vec<String>,
    /// Standard deviations of what makes the pressures unequal: relative, and in s.
    pub unequal: [f64; 2],
    /// Microphones that give nothing, by their numbers in the rig.
    dead: Vec<usize>,
    /// What `[microphones]` states.
    microphones: Option<MicrophoneKeys>,
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
    channels: Option<Listed>,
    full_scale_pa: Option<f64>,
    full_scale: Option<Given>,
    #[serde(default)]
    dead: Vec<usize>,
    #[serde(default)]
    arrays: Arrays,
    measured: Option<Elsewhere>,
    random: Option<DrivenKeys>,
    sweep: Option<DrivenKeys>,
    microphones: Option<MicrophoneKeys>,
    blow: Option<BlowKeys>,
    comparison: Option<ComparisonKeys>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ComparisonKeys {
    files: Vec<String>,
    gain_sd: Option<Given>,
    delay_sd: Option<Given>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BlowKeys {
    /// From and to, s after the onset.
    stretch_s: [f64; 2],
    files: Vec<String>,
    state: Vec<BlowState>,
}

impl Excitation {
    /// Lists of records that count each as a measurement of its own, with their places in the manifest.
    fn lists(&self) -> Vec<Vec<(String, &String)>> {
        fn of<'a>(place: &str, files: &'a [String]) -> Vec<(String, &'a String)> {
            files.iter().enumerate().map(|(k, file)| (format!("{place}[{k}] `{file}`"), file)).collect()
        }
        match self {
            Self::Blow(blow) => vec![of("[blow]: files", &blow.files)],
            Self::Comparison(found) => vec![of("[comparison]: files", &found.files)],
            Self::Driven(driven) => {
                let points =
                    driven.points.iter().flat_map(|(p, files)| of(&format!("point `{p}`: files"), files));
                let switched = driven.switched.iter().map(|s| (format!("switched `{}`", s.file), &s.file));
                vec![points.collect(), of("straight", &driven.straight).into_iter().chain(switched).collect()]
            }
        }
    }

    /// Whether `[microphones]` states gains, a sensitivity among them, by which numbers are divided later.
    fn states_gains(&self) -> bool {
        match self {
            Self::Blow(_) => false,
            Self::Comparison(found) => found.microphones.is_some(),
            Self::Driven(driven) => driven.microphones.is_some(),
        }
    }

    /// A file that one list has twice, where two measurements ought to be: its two places.
    fn listed_twice(&self) -> Option<[String; 2]> {
        self.lists().into_iter().find_map(|list| {
            let mut seen: BTreeMap<String, String> = BTreeMap::new();
            list.into_iter()
                .find_map(|(place, file)| seen.insert(plain(file), place.clone()).map(|first| [first, place]))
        })
    }
}

impl Comparison {
    /// Sensitivities that `[microphones]` of the manifest at `path` states for `count` microphones, V/Pa;
    /// none where records are compared as they are.
    ///
    /// # Errors
    /// A unit, a number or a list that cannot be; gains or delays, which the records shall tell.
    pub fn sensitivities(&self, count: usize, path: &Path) -> Result<Vec<f64>, RigError> {
        let Some(keys) = &self.microphones else { return Ok(Vec::new()) };
        let Channels { sensitivities, stated } = Channels::read(keys, count, &self.dead, path)?;
        if stated.is_some() {
            let what = "states gains or delays that the comparison measures; leave all but `sensitivity` out";
            return Err(RigError::invalid(path, "[microphones]", Problem::Keys { what }));
        }
        Ok(sensitivities)
    }
}

/// What `[comparison]` says.
fn comparison(
    keys: &ComparisonKeys,
    microphones: Option<MicrophoneKeys>,
    dead: Vec<usize>,
    path: &Path,
) -> Result<Comparison, RigError> {
    if keys.files.is_empty() {
        let what = "must list files: records in which all microphones measure the same pressure";
        return Err(RigError::invalid(path, "[comparison]", Problem::Keys { what }));
    }
    let sd = |key: &str, given: &Option<Given>, unit: &'static str| {
        let place = format!("[comparison]: {key}");
        let value = given.as_ref().map_or(Ok(0.0), |given| given.of(unit));
        let value = value.map_err(|error| RigError::invalid(path, &place, Problem::Unit(error)))?;
        in_range(&place, value, 0.0, 1.0, unit)
            .map_err(|(place, problem)| RigError::invalid(path, place, problem))?;
        Ok(value)
    };
    let unequal = [sd("gain_sd", &keys.gain_sd, "1")?, sd("delay_sd", &keys.delay_sd, "s")?];
    Ok(Comparison { files: keys.files.clone(), unequal, dead, microphones })
}

/// What `[blow]` says, where the band is in Hz and `gains` tells whether the manifest has `[microphones]`.
fn of_blow(blow: BlowKeys, gains: bool, [low, high]: [f64; 2], path: &Path) -> Result<Blow, RigError> {
    let wrong = |place: &str, what| Err(RigError::invalid(path, place, Problem::Keys { what }));
    let stretch = blow.stretch_s;
    if !(0.0 <= stretch[0] && stretch[0] < stretch[1]) || blow.files.is_empty() || blow.state.is_empty() {
        let what = "must have a stretch_s that ascends from 0 or more, files, and a [[blow.state]]";
        return wrong("[blow]", what);
    }
    if gains {
        let what = "has no meaning for a blow, whose modes need no gains; leave it out";
        return wrong("[microphones]", what);
    }
    let within = |f: &f64| 0.5 * low <= *f && *f <= high;
    if !blow.state.iter().flat_map(|s| &s.near_hz).all(within) {
        return wrong("[[blow.state]]", "must have a near_hz within `band_hz`");
    }
    Ok(Blow { stretch, files: blow.files, states: blow.state })
}

/// Full scale of a manifest, and whether it is in V.
fn scale(manifest: &Manifest, path: &Path) -> Result<(f64, bool), RigError> {
    let wrong = |(place, problem)| RigError::invalid(path, place, problem);
    let (full, in_volts) = full_scale(manifest.full_scale_pa, manifest.full_scale.as_ref()).map_err(wrong)?;
    if full.is_infinite() {
        return Ok((1.0, in_volts));
    }
    if !in_volts && manifest.microphones.is_some() {
        let what = "must be in V beside [microphones], as in \"10 V\"";
        return Err(RigError::invalid(path, "`full_scale`", Problem::Keys { what }));
    }
    in_range("full_scale", full, 1e-9, 1e9, if in_volts { "V" } else { "Pa" }).map_err(wrong)?;
    Ok((full, in_volts))
}

impl ExcitedRecords {
    /// Opens a folder; none if its manifest is one of pings and clicks, or absent.
    ///
    /// # Errors
    /// File, place and remedy; [`RigError::Elsewhere`] if the data are other people's and not here.
    pub fn open(folder: &Path) -> Result<Option<Self>, RigError> {
        let path = folder.join("manifest.toml");
        if !path.exists() {
            return Ok(None);
        }
        let text = read_text(&path)?;
        let keys: toml::Table = parse_toml(&text, &path)?;
        if !["random", "sweep", "blow", "comparison"].iter().any(|key| keys.contains_key(*key)) {
            return Ok(None);
        }
        let manifest: Manifest = parse_toml(&text, &path)?;
        let wrong = |place: &str, what| Err(RigError::invalid(&path, place, Problem::Keys { what }));
        let [low, high] = manifest.band_hz;
        if low >= high {
            return wrong("`band_hz`", "must have the lower frequency first, as in [100, 900]");
        }
        if !(manifest.rate_hz > 0.0 && low > 0.0 && low < high && high < 0.5 * manifest.rate_hz) {
            return wrong(
                "`rate_hz`, `band_hz`",
                "must be above zero, and the band ascend below half the rate",
            );
        }
        if manifest.comparison.is_none() && !manifest.dead.is_empty() {
            return wrong("`dead`", "belongs to [comparison]; leave the microphone out of the rig");
        }
        let full_scale = scale(&manifest, &path)?;
        let excitation = match (manifest.random, manifest.sweep, manifest.blow, manifest.comparison) {
            (Some(random), None, None, None) => {
                Excitation::Driven(Box::new(driven(random, "[random]", manifest.microphones, &path)?))
            }
            (None, Some(sweep), None, None) => {
                Excitation::Driven(Box::new(driven(sweep, "[sweep]", manifest.microphones, &path)?))
            }
            (None, None, Some(blow), None) => {
                Excitation::Blow(of_blow(blow, manifest.microphones.is_some(), [low, high], &path)?)
            }
            (None, None, None, Some(keys)) => Excitation::Comparison(Box::new(comparison(
                &keys,
                manifest.microphones,
                manifest.dead,
                &path,
            )?)),
            _ => {
                return wrong(
                    "[random], [sweep], [blow], [comparison]",
                    "exclude each other; put the records into folders of their own",
                );
            }
        };
        if let Some([first, place]) = excitation.listed_twice() {
            return Err(RigError::invalid(&path, place, Problem::ListedTwice { first }));
        }
        let folder = match &manifest.measured {
            None => folder.to_owned(),
            Some(elsewhere) => elsewhere
                .find()
                .ok_or_else(|| RigError::Elsewhere { path: path.clone(), data: elsewhere.clone() })?,
        };
        let Manifest { kind, source, rate_hz, band_hz, channels, arrays, .. } = manifest;
        Ok(Some(Self {
            path,
            kind,
            source,
            rate_hz,
            band_hz,
            excitation,
            channels,
            full_scale,
            arrays,
            folder,
        }))
    }

    /// Reads one record. Integers are parts of full scale, floats as they are. A dead microphone has no
    /// samples.
    ///
    /// # Errors
    /// As [`read_record`]; another number of microphones than `microphones`, if that is stated.
    pub fn read(&self, file: &str, microphones: Option<usize>) -> Result<Record, RigError> {
        let path = self.folder.join(file);
        let dead = match &self.excitation {
            Excitation::Comparison(found) => found.dead.clone(),
            _ => Vec::new(),
        };
        if let (Some(count), Some(&index)) = (microphones, dead.iter().max())
            && index >= count
        {
            return Err(RigError::invalid(&self.path, "dead", Problem::NoSuchIndex { index, count }));
        }
        let (places, names) = match (&self.channels, microphones) {
            (Some(listed), _) => listed
                .channels(microphones, &dead)
                .map_err(|(place, problem)| RigError::invalid(&self.path, place, problem))?,
            (None, Some(count)) => ((0..count).map(Some).collect(), BTreeMap::new()),
            (None, None) => ((0..self.count(&path)?).map(Some).collect(), BTreeMap::new()),
        };
        let layout = Layout {
            channels: &places,
            full_scale: self.full_scale.0,
            rate_hz: self.rate_hz,
            quiet: 0,
            arrays: &self.arrays,
            reading: &Reading {
                names,
                dead,
                full_scale_in_volts: self.full_scale.1,
                volts_stay: self.full_scale.1 || self.excitation.states_gains(),
                ..Reading::default()
            },
        };
        read_record(&path, layout)
    }

    /// How many channels a file has, in the arrays that hold the record.
    fn count(&self, path: &Path) -> Result<usize, RigError> {
        let names = &self.arrays.names;
        let is_of = |channel: &str, array: &String| {
            channel.strip_prefix(array.as_str()).is_some_and(|rest| rest.is_empty() || rest.starts_with('['))
        };
        let is_used = |c: &&ChannelContents| {
            names.is_empty() || c.name.as_ref().is_some_and(|name| names.iter().any(|a| is_of(name, a)))
        };
        Ok(inspect(path)?.channels.iter().filter(is_used).count())
    }
}
