//! Records of random noise, sweeps, periodic sounds and blows, and of compared microphones: what they say of
//! a rig, written as observations.

use crate::made::{Made, head, point_of};
use crate::{
    OpenStudy, compared,
    driven::{driven, unclipped},
};
use rijke_numerics::words::with_sd;
use rijke_numerics::{Classify, Failed, StagedFolder, Tell, write_within};
use rijke_rig::{Blow, Excitation, ExcitedRecords, RigError};
use rijke_signal::{BlowMode, BlowOptions, combine_blows, fit_blow};
use rijke_study::Study;
use serde_json::{Value, json};
use std::f64::consts::TAU;
use std::path::Path;

/// What is written; other files in the folder are kept.
const WRITTEN: [&str; 6] =
    ["observations.toml", CHANGED, "modes.csv", "gains.csv", "pressures", "transmission"];

/// An `observations.toml` that was not written here, or was changed by hand since.
const CHANGED: &str = "observations.toml.old";

/// Such records, and the study of their rig.
#[derive(Debug)]
pub struct Excited {
    /// The records.
    pub records: ExcitedRecords,
    /// The study.
    pub study: Study,
}

/// What a folder of excited records holds.
pub(crate) enum Checked {
    /// So many records, which can all be processed.
    Records(usize),
    /// They are other people's and not here, as this warning says.
    Elsewhere(String),
}

impl Excited {
    /// Opens such records of a study or in a folder beside its study; none if the records are pings and
    /// clicks.
    pub fn open(dir: &Path, open: OpenStudy<'_>) -> Result<Option<Self>, Failed> {
        let is_study = dir.join("study.toml").exists();
        let folder = if is_study { dir.join("records") } else { dir.to_owned() };
        let Some(records) = ExcitedRecords::open(&folder).or_bad_input()? else { return Ok(None) };
        // Of a folder `comparison` that is named within the folder of a study, the study is there.
        let beside = dir.parent().map(|p| if p.as_os_str().is_empty() { Path::new(".") } else { p });
        let study = open(if is_study { dir } else { beside.unwrap_or(dir) })?;
        let is_of_the_rig = folder.canonicalize().ok() == study.folder.join("records").canonicalize().ok();
        if is_of_the_rig && matches!(records.excitation, Excitation::Comparison(_)) {
            return Err(Failed::bad_input("a comparison of microphones measures nothing of the rig")
                .at(&records.path)
                .remedy(
                    "Put it into a folder of its own in the study, and run `rijke process` with that folder.",
                ));
        }
        Ok(Some(Self { records, study }))
    }

    /// Takes every step of processing and keeps nothing, so that what is refused later is refused here; none
    /// for records of pings and clicks.
    pub(crate) fn checked(dir: &Path, open: OpenStudy<'_>) -> Result<Option<Checked>, Failed> {
        if let Err(error @ RigError::Elsewhere { .. }) = ExcitedRecords::open(dir) {
            return Ok(Some(Checked::Elsewhere(error.to_string())));
        }
        let Some(Self { records, study }) = Self::open(dir, open)? else { return Ok(None) };
        Ok(Some(Checked::Records(match &records.excitation {
            Excitation::Blow(blow) => {
                blows(&records, blow, &study, &())?;
                blow.files.len()
            }
            Excitation::Comparison(comparison) => {
                compared::compared(&records, comparison, &study)?;
                comparison.files.len()
            }
            Excitation::Driven(found) => {
                driven(&records, found, &study, &())?;
                found.straight.len() + found.switched.len() + found.points.values().flatten().count()
            }
        })))
    }

    /// Processes them into observations of the study, or into a table of its microphones; in the folder `out`
    /// or, without one, beside the study's files. What was found, as JSON.
    pub fn observe(&self, out: Option<&Path>, force: bool, tell: &dyn Tell) -> Result<Value, Failed> {
        let Self { records, study } = self;
        let beside = match &records.excitation {
            Excitation::Comparison(_) => records.path.with_file_name(""),
            _ => study.folder.join("observations"),
        };
        let out = out.unwrap_or(&beside);
        let made = |make: &dyn Fn() -> Result<Made, Failed>| {
            let folder = StagedFolder::beside_others(out, "observations.toml", &WRITTEN, force)?;
            let before = rijke_numerics::read_text(&out.join(WRITTEN[0])).ok();
            let (mut files, answer) = make()?;
            let changed = |old: &String| files.iter().all(|(name, text)| name != WRITTEN[0] || text != old);
            if let Some(old) = before.filter(changed) {
                tell.note(format!(
                    "warning: observations.toml in {} differs from the one that is written now; it is kept as {CHANGED}",
                    out.display()
                ));
                files.push((CHANGED.to_owned(), old));
            }
            files.iter().try_for_each(|(name, text)| write_within(folder.path(), name, text))?;
            folder.commit()?;
            Ok(answer)
        };
        match &records.excitation {
            Excitation::Comparison(found) => compared::run(records, found, study, out, force, tell),
            Excitation::Driven(found) => made(&|| driven(records, found, study, tell)),
            Excitation::Blow(blow) => made(&|| blows(records, blow, study, tell)),
        }
    }
}

/// Modes of the states that a blow lets sound.
fn blows(records: &ExcitedRecords, blow: &Blow, study: &Study, tell: &dyn Tell) -> Result<Made, Failed> {
    for state in &blow.states {
        point_of(study, &state.point, "[[blow.state]]", records)?;
    }
    let options = BlowOptions {
        stretch_s: blow.stretch,
        highest_hz: records.band_hz[1],
        near_hz: blow.states.iter().flat_map(|s| s.near_hz.clone()).collect(),
    };
    let mut fits = Vec::new();
    for file in &blow.files {
        let channels = unclipped(records, file, None, &[])?;
        let fit = fit_blow(&channels, records.rate_hz, &options).map_err(|fault| {
            Failed::bad_input(fault)
                .at(&records.path)
                .remedy(format!("Look at {file}, or change `stretch_s`."))
        })?;
        let onsets: Vec<String> = fit.onsets_s.iter().map(|t| format!("{:.1}", 1e3 * t)).collect();
        tell.say(format!("{file}: onset at {} ms", onsets.join(", ")));
        if onsets.len() > 1 {
            tell.note(format!("{file}: several blows; the first alone is used, up to the next"));
        }
        fits.push(fit);
    }
    let combined = combine_blows(&fits);
    for (record, why) in &combined.outliers {
        tell.note(format!("{}: left out of the mean of a mode: {why}", blow.files[*record]));
    }
    let mut found = combined.modes.into_iter();
    let mut text =
        "point,mode,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n".to_owned();
    let mut modes = Vec::new();
    for state in &blow.states {
        for near in &state.near_hz {
            let Some(BlowMode { s, covariance }) = found.next().flatten() else {
                tell.note(format!("{}: no mode near {near} Hz", state.point));
                continue;
            };
            let [growth_sd, frequency_sd] = [covariance[(0, 0)].sqrt(), covariance[(1, 1)].sqrt() / TAU];
            let frequency = s.im / TAU;
            text +=
                &format!("{},{near:.0} Hz,{},{growth_sd},{frequency},{frequency_sd}\n", state.point, s.re);
            tell.say(format!(
                "{}: {} Hz, growth rate {} 1/s",
                state.point,
                with_sd(frequency, frequency_sd),
                with_sd(s.re, growth_sd)
            ));
            modes.push(json!({ "point": state.point, "frequency": [frequency, frequency_sd], "growth_rate": [s.re, growth_sd] }));
        }
    }
    let files = vec![("modes.csv".to_owned(), text), ("observations.toml".to_owned(), head(records))];
    Ok((files, json!({ "modes": modes })))
}
