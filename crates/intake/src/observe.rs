//! Records of pings and clicks to observations: opened beside their study, processed, written.

use crate::OpenStudy;
use rijke_flow::{HeatedTube, Ramp};
use rijke_numerics::{Classify, Failed, StagedFolder, Tell};
use rijke_rig::{Described, OperatingPoint, RecordFolder, RecordSet, RecordSource, Rejection};
use rijke_signal::{
    ChannelPriors, Kept, ProcessError, ProcessOptions, Processed, process, process_again, record_count,
};
use rijke_study::{MadeOf, Study};
use std::collections::BTreeSet;
use std::path::Path;

/// Records of pings and clicks, and what is known of them.
pub struct Intake {
    records: Records,
    /// The heated tube in which they were taken, if it was one.
    tube: Option<HeatedTube>,
    study: Option<Study>,
    /// How they are called in messages.
    name: String,
}

enum Records {
    Folder(Box<RecordFolder>),
    Laboratory(Box<dyn RecordSource>),
}

/// How records become observations, as far as neither manifest nor study says it.
#[derive(Clone, Debug, Default)]
pub struct ObserveOptions {
    /// Frequencies between which the mode of interest is sought, Hz.
    pub band_hz: Option<[f64; 2]>,
    /// Nominal frequency of the mains, Hz.
    pub mains_hz: Option<f64>,
    /// How equal the channels are where there are no calibration clicks at the pings' rate.
    pub channels: Option<ChannelPriors>,
    /// Largest distance of a channel's gain from the median of all, relative to it; none for 30 %.
    pub gain_spread: Option<f64>,
}

/// Where observations go.
pub struct Out<'a> {
    /// The folder.
    pub folder: &'a Path,
    /// Whether one that exists is replaced.
    pub force: bool,
    /// What else is written into it, before it appears under its name.
    pub beside: &'a dyn Fn(&Processed, &Path) -> Result<(), Failed>,
}

/// At most so many pings are tried before all are fitted.
const TRIED: usize = 3;

/// What is written; other files in its folder are kept.
static WRITTEN: [&str; 14] = [
    Ramp::FILE,
    HeatedTube::FILE,
    "rig.toml",
    "points.csv",
    "pings.csv",
    "clicks.csv",
    "ping-repeats.csv",
    "click-repeats.csv",
    "rejections.csv",
    "corrections.csv",
    "channels.toml",
    "observations.toml",
    MadeOf::FILE,
    "plots",
];

impl Intake {
    /// Opens a folder of records, or of a study whose records lie in DIR/records.
    pub fn open(dir: &Path, open: OpenStudy<'_>) -> Result<Self, Failed> {
        let below = dir.join("records");
        let (folder, study) =
            if dir.join("study.toml").exists() { (below.as_path(), Some(dir)) } else { (dir, dir.parent()) };
        let study = study.filter(|s| s.join("study.toml").exists()).map(open).transpose()?;
        if let Some(study) = &study {
            study.is_the_rig_of(folder).or_bad_input()?;
        }
        let described = described(folder, study.as_ref())?;
        let mut records = RecordFolder::open_of(folder, described).or_bad_input()?;
        if let Some(study) = &study {
            records.name_microphones(&study.rig.microphones.names);
        }
        Ok(Self { name: dir.display().to_string(), ..Self::of(records, study)? })
    }

    /// Records of a study, of which more may come.
    pub fn of(mut records: RecordFolder, study: Option<Study>) -> Result<Self, Failed> {
        let points: Vec<OperatingPoint> = records.set().points.iter().map(|p| p.point.clone()).collect();
        let tube = HeatedTube::read_within(records.folder(), points.iter()).or_bad_input()?;
        if let Some(tube) = &tube {
            // Its points know what sound passes there.
            records.fill_ways(|point| tube.way(point));
        }
        let name = records.folder().display().to_string();
        Ok(Self { records: Records::Folder(Box::new(records)), tube, study, name })
    }

    /// Records of a laboratory, which are in no folder, and its tube.
    pub fn of_laboratory(records: Box<dyn RecordSource>, tube: HeatedTube) -> Self {
        let name = "virtual rig".to_owned();
        Self { records: Records::Laboratory(records), tube: Some(tube), study: None, name }
    }

    /// The records.
    pub fn source(&self) -> &dyn RecordSource {
        match &self.records {
            Records::Folder(records) => &**records,
            Records::Laboratory(records) => &**records,
        }
    }

    /// Warnings of files of the same content.
    pub(crate) fn twins(&self) -> Result<Vec<String>, Failed> {
        let Records::Folder(records) = &self.records else { return Ok(Vec::new()) };
        let said = |(a, b): &(String, String)| {
            format!("{b} holds the same bytes as {a}: check whether it was copied under another name")
        };
        Ok(records.twins().or_bad_input()?.iter().map(said).collect())
    }

    /// How they are fitted, and where that is stated.
    fn fits(&self, options: &ObserveOptions) -> (ProcessOptions, Option<String>) {
        let (set, study) = (self.source().set(), self.study.as_ref());
        let mut fits = ProcessOptions::default();
        let (found, why) = band(options.band_hz, set, study);
        fits.ping.band_hz = found;
        // Neighbours are looked for beyond the band.
        fits.ping.highest_hz = fits.ping.highest_hz.max(1.4 * found.1);
        let stated = mains(options.mains_hz, set, study);
        fits.ping.mains_hz = stated.unwrap_or(fits.ping.mains_hz);
        fits.ping.silent_channels = set.acquisition.may_be_silent;
        fits.click.mains_hz = fits.ping.mains_hz;
        (fits.gain_spread, fits.stated) = (options.gain_spread, options.channels);
        (fits, why)
    }

    /// Fits the first pings of a few points, and returns those that are rejected: a wrong band or stretch of
    /// silence rejects all records, and is found here before all are fitted.
    pub(crate) fn rejected_of_few(&self) -> Result<Vec<Rejection>, Failed> {
        let Records::Folder(records) = &self.records else { return Ok(Vec::new()) };
        let first: Vec<&str> =
            records.set().points.iter().filter_map(|p| p.pings.first()).map(String::as_str).collect();
        let tried: BTreeSet<&str> =
            first.iter().copied().step_by(first.len().div_ceil(TRIED).max(1)).collect();
        if tried.is_empty() {
            return Ok(Vec::new());
        }
        let few = records.restricted(|file| tried.contains(file));
        match process(&few, &self.fits(&ObserveOptions::default()).0, &|| ()) {
            Ok(processed) => Ok(processed.observations.rejections),
            Err(ProcessError::NothingUsable { record, reason, .. }) => Ok(vec![Rejection { record, reason }]),
            Err(error) => Err(Failed::of_input(&error).at(Path::new(&self.name))),
        }
    }

    /// Processes them into observations. Of records that still come, the fits that are `kept` are not made
    /// again, and what is written does not say of which files it was made.
    pub fn observe(
        &self,
        options: &ObserveOptions,
        kept: Option<&Kept>,
        out: &Out<'_>,
        tell: &dyn Tell,
    ) -> Result<Processed, Failed> {
        let (source, study) = (self.source(), self.study.as_ref());
        let mut said = if kept.is_some() { Vec::new() } else { self.twins()? };
        // A tube and ramps that stand beside observations whose records have none were put there by hand.
        let by_hand = match &self.tube {
            None => 2,
            Some(tube) if tube.ramps.is_empty() => 1,
            Some(_) => 0,
        };
        let staged =
            StagedFolder::beside_others(out.folder, "observations.toml", &WRITTEN[by_hand..], out.force)?;
        tell.after_killed_run(&staged);
        let (fits, why) = self.fits(options);
        said.extend(why);
        let progress = tell.progress("processing", record_count(source.set()) as u64);
        let processed = process_again(source, &fits, kept, &|| progress(1));
        drop(progress);
        let mut processed = processed.map_err(|error| match error {
            ProcessError::Record(error) => Failed::of_input(&error),
            other => Failed::of_input(&other).at(Path::new(&self.name)),
        })?;
        // Records with a campaign of their own know their days better than the plan of the study.
        let own = matches!(&self.records, Records::Folder(records) if records.has_own_campaign());
        if let Some(study) = study.filter(|_| !own) {
            said.extend(study.give_temperatures(&mut processed.observations));
        }
        processed.notes.splice(0..0, said);
        processed.observations.write(staged.path()).or_failed()?;
        if let Some(tube) = &self.tube {
            let points = &processed.observations.points;
            tube.write_within(staged.path(), &|id| points.iter().any(|p| p.point.id == id)).or_failed()?;
        }
        Rejection::write_all(&processed.corrections, &staged.path().join("corrections.csv")).or_failed()?;
        (out.beside)(&processed, staged.path())?;
        if let (Records::Folder(records), None) = (&self.records, kept) {
            let folder = records.folder();
            let of = MadeOf::records(folder).or_bad_input().map_err(|f| f.at(folder))?;
            let given = study.is_some() && !own;
            let of = if given { of.with_temperatures_of_campaign() } else { of };
            of.write(staged.path()).or_failed()?;
        }
        staged.commit()?;
        Ok(processed)
    }
}

/// What is known of the records in `folder` where their manifest names no files: of a heated tube its
/// `tube.toml` says what the rig is, and else the study.
pub fn described(folder: &Path, study: Option<&Study>) -> Result<Described, Failed> {
    let Some(study) = study else { return Ok(Described::default()) };
    let points = study.campaign.operating_points();
    let tube = HeatedTube::read_within(folder, points.iter()).or_bad_input()?;
    let rig = match tube {
        Some(tube) => tube.rig.apparatus(),
        None => study.apparatus().or_bad_input()?,
    };
    Ok(Described { rig: Some(rig), points: Some(points) })
}

/// The band of the wanted mode, Hz, and for a study what states it.
fn band(option: Option<[f64; 2]>, set: &RecordSet, study: Option<&Study>) -> ((f64, f64), Option<String>) {
    let usual = ProcessOptions::default().ping.band_hz;
    let recorded = study.and_then(|s| s.rig.ping_band_hz);
    let searched = study.filter(|s| s.rig.search_is_stated[1]).map(|s| s.rig.search[1]);
    let (band, why) = match (option, set.acquisition.band_hz, recorded, searched) {
        (Some([low, high]), _, _, _) => return ((low, high), None),
        (_, Some([low, high]), _, _) => ((low, high), "as `band_hz` of the manifest says"),
        (_, _, Some([low, high]), _) => ((low, high), "as `band_hz` of rig.toml says"),
        (_, _, _, Some([low, high])) => ((low, high), "as [search] of rig.toml says"),
        _ => return (usual, None),
    };
    (band, Some(format!("the mode is sought from {} to {} Hz, {why}", band.0, band.1)))
}

/// The frequency of the mains, Hz, if option, manifest or study state it.
fn mains(option: Option<f64>, set: &RecordSet, study: Option<&Study>) -> Option<f64> {
    option.or(set.acquisition.mains_hz).or_else(|| study?.rig.mains_hz)
}
