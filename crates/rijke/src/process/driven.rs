//! `rijke process` of records of a rig that random noise, a sweep or a periodic sound drives: gains of the
//! channels, pressures, transmission.

use super::made::{Made, head, point_of};
use super::switched;
use crate::{
    failure::{Classify, Failure},
    ui::Ui,
};
use rijke_numerics::C64;
use rijke_rig::{Driven, ExcitedRecords, Specimen, SpectraKind, StatedChannels};
use rijke_signal::{Fault, Spectra, Swept, SweptOptions, SwitchedGains, TransmissionTube};
use rijke_study::Study;
use serde_json::{Value, json};
use std::f64::consts::TAU;

/// Gains of the channels.
enum Gains {
    Switched(SwitchedGains),
    Stated(StatedChannels),
    /// Nothing is known of them.
    Equal,
}

/// Pressures over that at the first microphone, by frequency and microphone.
struct Heard {
    frequency_hz: Vec<f64>,
    pressures: Vec<Vec<C64>>,
    /// Standard deviations of the real and of the imaginary part of the logarithms.
    relative_sd: Vec<Vec<f64>>,
    /// Frequencies that were left out.
    left_out: usize,
}

/// Gains of the channels, pressures at the operating points over that at the first microphone, and what
/// specimens let through.
pub(super) fn driven(
    records: &ExcitedRecords,
    driven: &Driven,
    study: &Study,
    ui: &Ui,
) -> Result<Made, Failure> {
    let names = &study.rig.microphones.names;
    let n = names.len();
    let made = Records { records, driven, names };
    let is_whole = matches!(driven.spectra, SpectraKind::Whole { .. });
    let table = if is_whole { "sweep" } else { "random" };
    if let Some(strange) = driven.switched.iter().find(|s| !(1..n).contains(&s.channel)) {
        return Err(Failure::bad_input(format!(
            "[[{table}.switched]]: channel {} of {}",
            strange.channel, strange.file
        ))
        .at(&records.path)
        .remedy(format!(
            "Give a channel from 1 to {}: the one that changed places with channel 0.",
            n.saturating_sub(1)
        )));
    }
    let (mut files, mut pairs) = (Vec::new(), Vec::new());
    let gains = if driven.straight.is_empty() {
        match driven.stated(n, &records.path).or_bad_input()? {
            Some(stated) => Gains::Stated(stated),
            None => {
                ui.note("warning: the channels are taken to have the same gain, without error: add `straight` and `switched` records, or `[microphones]` with gains and their errors");
                Gains::Equal
            }
        }
    } else {
        let gains = made.switched()?;
        pairs = tell(&gains, names, ui);
        switched::say_inverted(&gains, driven, names, ui);
        files.push(("gains.csv".to_owned(), gains_table(&gains, names)));
        Gains::Switched(gains)
    };
    let mut toml = head(records);
    toml += "\n[[response]]\nkind = \"pressures\"\n";
    if let Some(sources) = &driven.sources {
        toml += &format!("sources = {}\n", json!(sources));
    }
    toml += "[response.files]\n";
    let (mut points, mut losses, mut checks) = (Vec::new(), Vec::new(), Vec::new());
    for (point, list) in &driven.points {
        let index = point_of(study, point, &format!("[{table}.points]"), records)?;
        let heard = made.heard(list, &gains)?;
        toml += &format!("{} = \"pressures/{point}.csv\"\n", json!(point));
        let cells = |c: usize, k: usize| {
            let p = heard.pressures[k][c];
            vec![p.re, p.im, heard.relative_sd[k][c] * p.norm()]
        };
        let text = rows_of(&heard.frequency_hz, names, "", cells, &["_re", "_im", "_sd"]);
        files.push((format!("pressures/{point}.csv"), text));
        if is_whole {
            let (used, of) = (heard.frequency_hz.len(), heard.frequency_hz.len() + heard.left_out);
            let mut sds: Vec<f64> = heard.relative_sd.iter().flatten().copied().collect();
            sds.sort_by(f64::total_cmp);
            let middle = sds[sds.len() / 2];
            ui.say(format!(
                "{point}: {used} of {of} frequencies, relative standard deviation {middle:.1e} (median)"
            ));
            points.push(json!({ "point": point, "frequencies": used, "left_out": heard.left_out, "relative_sd": middle }));
        }
        let Some(specimen) = &driven.transmission else { continue };
        let (text, bands) = transmission(&heard, specimen, study, index, records)?;
        files.push((format!("transmission/{point}.csv"), text));
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
    // The errors of Welch's spectra are those of ratios, which share that of the first microphone: the noise
    // of a stage stands for them.
    let ends: &[&str] = if is_whole { &["re", "im", "sd"] } else { &["re", "im"] };
    for name in names {
        ends.iter().for_each(|end| toml += &format!("{name}_{end} = \"{name}_{end}\"\n"));
    }
    files.push(("observations.toml".to_owned(), toml));
    let answer = json!({ "pairs": pairs, "points": points, "transmission": losses, "empty": checks });
    Ok((files, answer))
}

/// The records of a manifest, on their way to spectra.
struct Records<'a> {
    records: &'a ExcitedRecords,
    driven: &'a Driven,
    names: &'a [String],
}

impl Records<'_> {
    fn read(&self, file: &str) -> Result<Vec<Vec<f64>>, Failure> {
        Ok(self.records.read(file, Some(self.names.len())).or_bad_input()?.channels)
    }

    /// A fault of records as a failure.
    fn fault(&self, files: &[String], fault: &Fault) -> Failure {
        let listed = files.join(", ");
        let remedy = match (fault, self.driven.spectra) {
            (Fault::DeadChannel { channel, .. }, _) => {
                format!("Leave microphone {} out of the rig, or record {listed} again.", self.names[*channel])
            }
            (_, SpectraKind::Segments { .. }) => format!("Look at {listed}, or shorten `segment`."),
            _ => format!("Look at {listed}, or change `band_hz`, `resolution_hz` or `period`."),
        };
        Failure::bad_input(format!("{listed}: {fault}")).at(&self.records.path).remedy(remedy)
    }

    fn swept(&self, files: &[String], resolution_hz: f64, period: Option<usize>) -> Result<Swept, Failure> {
        let all = files.iter().map(|file| self.read(file)).collect::<Result<Vec<_>, _>>()?;
        let options = SweptOptions { band_hz: self.records.band_hz, resolution_hz, period };
        Swept::new(&all, self.records.rate_hz, &options).map_err(|fault| self.fault(files, &fault))
    }

    fn spectra(&self, files: &[String]) -> Result<Spectra, Failure> {
        match self.driven.spectra {
            SpectraKind::Whole { resolution_hz, period, .. } => {
                Ok(self.swept(files, resolution_hz, period)?.spectra)
            }
            SpectraKind::Segments { segment } => {
                let channels = files.first().map(|file| self.read(file)).transpose()?.unwrap_or_default();
                Spectra::welch(&channels, self.records.rate_hz, segment, self.records.band_hz)
                    .map_err(|fault| self.fault(files, &fault))
            }
        }
    }

    /// Gains from records in which channels have changed places.
    fn switched(&self) -> Result<SwitchedGains, Failure> {
        let straight = self.spectra(&self.driven.straight)?;
        let one =
            |s: &rijke_rig::SwitchedRecord| Ok((s.channel, self.spectra(std::slice::from_ref(&s.file))?));
        let switched: Vec<(usize, Spectra)> =
            self.driven.switched.iter().map(one).collect::<Result<_, Failure>>()?;
        let polynomials = self.driven.polynomials;
        let gains = SwitchedGains::new(&straight, &switched, self.names.len(), polynomials)
            .map_err(|fault| Failure::bad_input(fault).at(&self.records.path))?;
        match gains.doubt(&straight, &switched, polynomials) {
            Some(doubt) => Err(switched::failure(&doubt, self.driven, self.names).at(&self.records.path)),
            None => Ok(gains),
        }
    }

    /// What the microphones hear in the records of an operating point.
    fn heard(&self, files: &[String], gains: &Gains) -> Result<Heard, Failure> {
        let n = self.names.len();
        let SpectraKind::Whole { resolution_hz, period, coherence } = self.driven.spectra else {
            let found = self.spectra(files)?;
            let transfers: Vec<_> = (0..n).map(|c| found.transfer(0, c)).collect();
            let rows = (0..found.frequency_hz.len()).map(|k| {
                let f = found.frequency_hz[k];
                let of = |c: usize| {
                    let (gain, gain_sd) = gains.at(c, k, f);
                    let own = if c == 0 { 0.0 } else { transfers[c][k].relative_sd };
                    (transfers[c][k].even() / gain, own.hypot(gain_sd))
                };
                (0..n).map(of).unzip::<_, _, Vec<C64>, Vec<f64>>()
            });
            let (pressures, relative_sd) = rows.unzip();
            return Ok(Heard { frequency_hz: found.frequency_hz, pressures, relative_sd, left_out: 0 });
        };
        let found = self.swept(files, resolution_hz, period)?;
        let all = &found.spectra.frequency_hz;
        if let Gains::Switched(gains) = gains
            && gains.frequency_hz != *all
        {
            let what = format!("{}: not as long as the records of `straight`", files.join(", "));
            return Err(Failure::bad_input(what)
                .at(&self.records.path)
                .remedy("Record all sweeps for the same time, or cut the files to one length."));
        }
        let used: Vec<usize> = (0..all.len()).filter(|k| found.fields[*k].coherence >= coherence).collect();
        if used.is_empty() {
            let what = format!("{}: no frequency has a coherence of {coherence}", files.join(", "));
            return Err(Failure::bad_input(what).at(&self.records.path).remedy(
                "Look whether `band_hz` holds the frequencies of the sweep; drive it longer or louder, or lower `coherence`.",
            ));
        }
        let rows = used.iter().map(|&k| {
            let field = &found.fields[k];
            let first = field.pressures[0] / gains.at(0, k, all[k]).0;
            let of = |c: usize| {
                let ((gain, gain_sd), p) = (gains.at(c, k, all[k]), field.pressures[c]);
                (p / gain / first, (field.sd / p.norm()).hypot(gain_sd))
            };
            (0..n).map(of).unzip::<_, _, Vec<C64>, Vec<f64>>()
        });
        let (pressures, relative_sd) = rows.unzip();
        let left_out = all.len() - used.len();
        Ok(Heard { frequency_hz: used.iter().map(|&k| all[k]).collect(), pressures, relative_sd, left_out })
    }
}

impl Gains {
    /// The gain of channel `c` at frequency `f`, the `k`-th, and the standard deviation of each part of its
    /// logarithm.
    fn at(&self, c: usize, k: usize, f: f64) -> (C64, f64) {
        match self {
            Self::Switched(gains) => (gains.gains[c][k], gains.relative_sd[c][k]),
            Self::Stated(s) => {
                let gain = C64::from_polar(s.gains[c], -TAU * f * s.delays[c]);
                (gain, s.gain_sds[c].hypot(TAU * f * s.delay_sds[c]))
            }
            Self::Equal => (C64::ONE, 0.0),
        }
    }
}

/// Says what the gains are, and how far their estimates lie from each other.
fn tell(gains: &SwitchedGains, names: &[String], ui: &Ui) -> Vec<Value> {
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
    pairs
}

fn gains_table(gains: &SwitchedGains, names: &[String]) -> String {
    let cells = |c: usize, k: usize| {
        let g = gains.gains[c][k];
        vec![g.re, g.im, gains.relative_sd[c][k]]
    };
    rows_of(&gains.frequency_hz, names, "gain", cells, &["_re", "_im", "_sd"])
}

/// What a specimen lets through: a table by frequency, and medians in bands.
fn transmission(
    heard: &Heard,
    specimen: &Specimen,
    study: &Study,
    point: usize,
    records: &ExcitedRecords,
) -> Result<(String, Vec<[f64; 7]>), Failure> {
    let layout = study.rig.at_factors(&study.campaign.points[point].factors, study.rig.temperature);
    let layout = layout.map_err(|problem| Failure::bad_input(problem).at(&study.folder.join("rig.toml")))?;
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
    for ((f, p), sds) in heard.frequency_hz.iter().zip(&heard.pressures).zip(&heard.relative_sd) {
        let Some(through) = tube.transmitted(*f, p) else { continue };
        let sds_of_places = [specimen.place_sd, specimen.sound_speed_sd];
        let [loss, loss_sd] = tube.loss(*f, p, sds, sds_of_places).unwrap_or([f64::NAN; 2]);
        let [down, up] = through.through;
        text +=
            &format!("{f},{loss},{loss_sd},{},{},{},{},{}\n", through.energy, down.re, down.im, up.re, up.im);
        rows.push([*f, loss, loss_sd, through.energy, down.norm(), up.norm()]);
    }
    Ok((text, bands(&rows)))
}

/// A table of numbers by frequency and channel.
fn rows_of(
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
