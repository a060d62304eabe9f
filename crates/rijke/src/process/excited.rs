//! `rijke process` of records of random noise and of blows.

use crate::{
    failure::{Classify, Failure},
    staging::{StagedFolder, write_whole},
    ui::Ui,
};
use rijke_numerics::C64;
use rijke_rig::{Blow, Excitation, ExcitedRecords, RandomNoise};
use rijke_signal::{
    BlowMode, BlowOptions, Fault, Spectra, SwitchedGains, TransmissionTube, combine_blows, fit_blow,
};
use rijke_study::Study;
use serde_json::{Value, json};
use std::f64::consts::TAU;
use std::path::Path;

/// What is written; other files in the folder are kept.
const WRITTEN: [&str; 6] =
    ["observations.toml", CHANGED, "modes.csv", "gains.csv", "pressures", "transmission"];

/// An `observations.toml` that was not written here, or was changed by hand since.
const CHANGED: &str = "observations.toml.old";

/// Opens such records of a study or a folder beside its study; none if the records are pings and clicks.
pub(super) fn open(dir: &Path) -> Result<Option<(ExcitedRecords, Study)>, Failure> {
    let is_study = dir.join("study.toml").is_file();
    let folder = if is_study { dir.join("records") } else { dir.to_owned() };
    let Some(records) = ExcitedRecords::open(&folder).or_bad_input()? else { return Ok(None) };
    let study = if is_study { Some(dir) } else { dir.parent() };
    Ok(Some((records, crate::study::open(study.unwrap_or(dir))?)))
}

/// Reads every record of such a folder: how many there are; none for records of pings and clicks.
pub(crate) fn files_of(dir: &Path) -> Result<Option<usize>, Failure> {
    let Some((records, _)) = open(dir)? else { return Ok(None) };
    let files: Vec<&String> = match &records.excitation {
        Excitation::Blow(blow) => blow.files.iter().collect(),
        Excitation::Random(random) => {
            let switched = random.switched.iter().map(|s| &s.file);
            [&random.straight].into_iter().chain(switched).chain(random.points.values()).collect()
        }
    };
    for file in &files {
        records.read(file, None).or_bad_input()?;
    }
    Ok(Some(files.len()))
}

/// Processes them into observations of the study.
pub(super) fn run(
    records: &ExcitedRecords,
    study: &Study,
    out: &Path,
    force: bool,
    ui: &Ui,
) -> Result<(), Failure> {
    let folder = StagedFolder::beside_others(out, "observations.toml", &WRITTEN, force)?;
    let before = std::fs::read_to_string(out.join(WRITTEN[0])).ok();
    let (mut files, answer) = match &records.excitation {
        Excitation::Random(random) => noise(records, random, study, ui)?,
        Excitation::Blow(blow) => blows(records, blow, study, ui)?,
    };
    let changed = |old: &String| files.iter().all(|(name, text)| name != WRITTEN[0] || text != old);
    if let Some(old) = before.filter(changed) {
        ui.note(format!(
            "warning: observations.toml in {} differs from the one that is written now; it is kept as {CHANGED}",
            out.display()
        ));
        files.push((CHANGED.to_owned(), old));
    }
    for (name, text) in files {
        let path = folder.path().join(name);
        path.parent().map_or(Ok(()), std::fs::create_dir_all).or_failed().map_err(|f| f.at(&path))?;
        write_whole(&path, text.as_bytes())?;
    }
    folder.commit()?;
    ui.result(&answer)
}

/// Names and texts of files, and the answer of the command.
type Made = (Vec<(String, String)>, Value);

fn faulty(path: &Path) -> impl Fn(Fault) -> Failure {
    let path = path.to_owned();
    move |fault| Failure::bad_input(fault).at(&path)
}

/// The head of `observations.toml`.
fn head(records: &ExcitedRecords) -> String {
    let kind = if records.kind == rijke_rig::DataKind::Measured { "measured" } else { "virtual" };
    format!("kind = \"{kind}\"\nsource = {}\n", json!(records.source))
}

/// The place of an operating point that the manifest names.
fn point_of(study: &Study, point: &str, key: &str, records: &ExcitedRecords) -> Result<usize, Failure> {
    study.campaign.point(point).map(|(index, _)| index).ok_or_else(|| {
        let known: Vec<&str> = study.campaign.points.iter().map(|p| p.id.as_str()).collect();
        Failure::bad_input(format!("there is no operating point `{point}`; known: {}", known.join(", ")))
            .at(&records.path)
            .remedy(format!("Correct the name in {key}, or add the point to campaign.csv."))
    })
}

/// Gains of the channels, pressures at the operating points over that at the first microphone, and what specimens let through.
fn noise(records: &ExcitedRecords, random: &RandomNoise, study: &Study, ui: &Ui) -> Result<Made, Failure> {
    let names = &study.rig.microphones.names;
    let n = names.len();
    let spectra = |file: &str| {
        let record = records.read(file, Some(n)).or_bad_input()?;
        let found = Spectra::welch(&record.channels, records.rate_hz, random.segment, records.band_hz);
        found.map_err(|fault| {
            let remedy = match fault {
                Fault::DeadChannel { channel, .. } => {
                    format!("Leave microphone {} out of the rig, or record {file} again.", names[channel])
                }
                _ => format!("Look at {file}, or shorten `segment`."),
            };
            Failure::bad_input(format!("{file}: {fault}")).at(&records.path).remedy(remedy)
        })
    };
    if let Some(strange) = random.switched.iter().find(|s| !(1..n).contains(&s.channel)) {
        return Err(Failure::bad_input(format!(
            "[[random.switched]]: channel {} of {}",
            strange.channel, strange.file
        ))
        .at(&records.path)
        .remedy(format!(
            "Give a channel from 1 to {}: the one that changed places with channel 0.",
            n.saturating_sub(1)
        )));
    }
    let straight = spectra(&random.straight)?;
    let switched: Vec<(usize, Spectra)> =
        random.switched.iter().map(|s| Ok((s.channel, spectra(&s.file)?))).collect::<Result<_, Failure>>()?;
    let gains =
        SwitchedGains::new(&straight, &switched, n, random.polynomials).map_err(faulty(&records.path))?;
    let mut pairs = Vec::new();
    for (c, name) in names.iter().enumerate().skip(1) {
        let of = gains.pairs.iter().filter(|p| p.channel == c);
        let told: Vec<String> =
            of.clone().map(|p| format!("{} {:.1e} +- {:.1e}", names[p.by], p.distance, p.sd)).collect();
        let middle = gains.gains[c].len() / 2;
        let g = gains.gains[c][middle];
        ui.say(format!(
            "{name}: gain {:.4} and phase {:.4} rad at {:.0} Hz, +- {:.1e}; distance of the estimates by {}",
            g.norm(),
            g.arg(),
            gains.frequency_hz[middle],
            gains.relative_sd[c][middle],
            told.join(", ")
        ));
        pairs.extend(of.map(|p| json!({ "channel": c, "by": p.by, "distance": p.distance, "sd": p.sd })));
    }
    let mut files = vec![(
        "gains.csv".to_owned(),
        table(
            &gains.frequency_hz,
            names,
            "gain",
            |c, k| {
                let g = gains.gains[c][k];
                vec![g.re, g.im, gains.relative_sd[c][k]]
            },
            &["_re", "_im", "_sd"],
        ),
    )];
    let mut toml = head(records);
    toml += "\n[[response]]\nkind = \"pressures\"\n";
    if let Some(sources) = &random.sources {
        toml += &format!("sources = {}\n", json!(sources));
    }
    toml += "[response.files]\n";
    let (mut losses, mut checks) = (Vec::new(), Vec::new());
    for (point, file) in &random.points {
        let index = point_of(study, point, "[random.points]", records)?;
        let found = spectra(file)?;
        let transfers: Vec<_> = (0..n).map(|c| found.transfer(0, c)).collect();
        let pressure = |c: usize, k: usize| transfers[c][k].even() / gains.gains[c][k];
        let sd = |c: usize, k: usize| {
            if c == 0 { 0.0 } else { transfers[c][k].relative_sd.hypot(gains.relative_sd[c][k]) }
        };
        toml += &format!("{} = \"pressures/{point}.csv\"\n", json!(point));
        files.push((
            format!("pressures/{point}.csv"),
            table(
                &found.frequency_hz,
                names,
                "",
                |c, k| {
                    let p = pressure(c, k);
                    vec![p.re, p.im, sd(c, k) * p.norm()]
                },
                &["_re", "_im", "_sd"],
            ),
        ));
        let Some(specimen) = &random.transmission else { continue };
        let layout = study.rig.at_factors(&study.campaign.points[index].factors, study.rig.temperature);
        let layout =
            layout.map_err(|problem| Failure::bad_input(problem).at(&study.folder.join("rig.toml")))?;
        let gas = study.rig.gas.at(study.rig.temperature, study.rig.pressure);
        let [from, to] = specimen.between;
        let before = layout.microphones.iter().filter(|x| **x <= from).count();
        let behind = layout.microphones.iter().filter(|x| **x >= to).count();
        if before < 2 || behind < 2 {
            return Err(Failure::bad_input(format!(
                "`between` of [random.transmission] has {before} microphones before the specimen and {behind} behind it; waves are told apart by two or more"
            ))
            .at(&records.path)
            .remedy("Correct `between`, or the places of the microphones in rig.toml."));
        }
        let tube = TransmissionTube {
            places: layout.microphones,
            between: specimen.between,
            sound_speed: gas.sound_speed,
        };
        let mut text =
            "f [Hz],loss [dB],loss_sd [dB],energy,downstream_re,downstream_im,upstream_re,upstream_im\n"
                .to_owned();
        let mut rows = Vec::new();
        for (k, f) in found.frequency_hz.iter().enumerate() {
            let p: Vec<C64> = (0..n).map(|c| pressure(c, k)).collect();
            let sds: Vec<f64> = (0..n).map(|c| sd(c, k)).collect();
            let Some(through) = tube.transmitted(*f, &p) else { continue };
            let [loss, loss_sd] = tube
                .loss(*f, &p, &sds, [specimen.place_sd, specimen.sound_speed_sd])
                .unwrap_or([f64::NAN; 2]);
            let [down, up] = through.through;
            text += &format!(
                "{f},{loss},{loss_sd},{},{},{},{},{}\n",
                through.energy, down.re, down.im, up.re, up.im
            );
            rows.push([*f, loss, loss_sd, through.energy, down.norm(), up.norm()]);
        }
        files.push((format!("transmission/{point}.csv"), text));
        let bands = bands(&rows);
        for b in &bands {
            if specimen.points.contains(point) {
                ui.say(format!(
                    "{point}, {:.0} to {:.0} Hz: transmission loss {:.2} +- {:.2} dB, energy {:.3}",
                    b[0], b[1], b[2], b[3], b[4]
                ));
            } else {
                ui.say(format!(
                    "{point}, {:.0} to {:.0} Hz: energy {:.3}, through it downstream {:.3} and upstream {:.3}",
                    b[0], b[1], b[4], b[5], b[6]
                ));
            }
        }
        let kept = if specimen.points.contains(point) { &mut losses } else { &mut checks };
        kept.push(json!({ "point": point, "bands": bands }));
    }
    toml += "[response.columns]\n\"f [Hz]\" = \"f\"\n";
    for name in names {
        toml += &format!("{name}_re = \"{name}_re\"\n{name}_im = \"{name}_im\"\n");
    }
    files.push(("observations.toml".to_owned(), toml));
    Ok((files, json!({ "pairs": pairs, "transmission": losses, "empty": checks })))
}

/// A table of numbers by frequency and channel.
fn table(
    frequency_hz: &[f64],
    names: &[String],
    what: &str,
    cells: impl Fn(usize, usize) -> Vec<f64>,
    ends: &[&str],
) -> String {
    let mut text = "f [Hz]".to_owned();
    for name in names {
        ends.iter()
            .for_each(|end| text += &format!(",{name}{}{what}{end}", if what.is_empty() { "" } else { "_" }));
    }
    for (k, f) in frequency_hz.iter().enumerate() {
        text += &format!("\n{f}");
        (0..names.len()).flat_map(|c| cells(c, k)).for_each(|v| text += &format!(",{v:e}"));
    }
    text + "\n"
}

/// Medians of all columns in bands of 100 Hz: from, to, and the columns behind the frequency.
fn bands(rows: &[[f64; 6]]) -> Vec<[f64; 7]> {
    let band = |row: &[f64; 6]| (row[0] / 100.0).floor();
    rows.chunk_by(|a, b| band(a) == band(b))
        .map(|rows| {
            let median = |j: usize| {
                let mut all: Vec<f64> = rows.iter().map(|row| row[j]).collect();
                all.sort_by(f64::total_cmp);
                all[all.len() / 2]
            };
            let from = 100.0 * band(&rows[0]);
            [from, from + 100.0, median(1), median(2), median(3), median(4), median(5)]
        })
        .collect()
}

/// Modes of the states that a blow lets sound.
fn blows(records: &ExcitedRecords, blow: &Blow, study: &Study, ui: &Ui) -> Result<Made, Failure> {
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
        let record = records.read(file, None).or_bad_input()?;
        let fit = fit_blow(&record.channels, records.rate_hz, &options).map_err(|fault| {
            Failure::bad_input(fault)
                .at(&records.path)
                .remedy(format!("Look at {file}, or change `stretch_s`."))
        })?;
        let onsets: Vec<String> = fit.onsets_s.iter().map(|t| format!("{:.1}", 1e3 * t)).collect();
        ui.say(format!("{file}: onset at {} ms", onsets.join(", ")));
        if onsets.len() > 1 {
            ui.note(format!("{file}: several blows; the first alone is used, up to the next"));
        }
        fits.push(fit);
    }
    let mut found = combine_blows(&fits).into_iter();
    let mut text =
        "point,mode,growth_rate [1/s],growth_rate_sd [1/s],frequency [Hz],frequency_sd [Hz]\n".to_owned();
    let mut modes = Vec::new();
    for state in &blow.states {
        for near in &state.near_hz {
            let Some(BlowMode { s, covariance }) = found.next().flatten() else {
                ui.note(format!("{}: no mode near {near} Hz", state.point));
                continue;
            };
            let [growth_sd, frequency_sd] = [covariance[(0, 0)].sqrt(), covariance[(1, 1)].sqrt() / TAU];
            let frequency = s.im / TAU;
            text +=
                &format!("{},{near:.0} Hz,{},{growth_sd},{frequency},{frequency_sd}\n", state.point, s.re);
            ui.say(format!(
                "{}: {frequency:.2} +- {frequency_sd:.2} Hz, growth rate {:.1} +- {growth_sd:.1} 1/s",
                state.point, s.re
            ));
            modes.push(json!({ "point": state.point, "frequency": [frequency, frequency_sd], "growth_rate": [s.re, growth_sd] }));
        }
    }
    let files = vec![("modes.csv".to_owned(), text), ("observations.toml".to_owned(), head(records))];
    Ok((files, json!({ "modes": modes })))
}
