//! Records of a rig that random noise, a sweep or a periodic sound drives: gains of the channels, pressures,
//! transmission.

use crate::made::{Files, Made, head, point_of};
use crate::switched;
use rijke_numerics::words::counted;
use rijke_numerics::{Classify, Failed, Tell};
use rijke_rig::{Driven, ExcitedRecords, Specimen, SpectraKind};
use rijke_signal::{
    Channel, ChannelGains, Fault, LossBand, PressureFault, RelativePressures, Spectra, Swept, SweptOptions,
    SwitchedGains, TransmissionLoss, TransmissionTube, TubeDuct, TubeErrors,
};
use rijke_study::{DuctAt, Study};
use serde_json::{Value, json};

/// Samples at full scale that a record may have: its peak, where it was scaled to that.
const FULL: usize = 2;

/// Share of the power of a microphone below which it is said to hear little of the source.
const HEARS_LITTLE: f64 = 0.5;

/// Gains of the channels, pressures at the operating points over that at the first microphone, and what
/// specimens let through.
pub(crate) fn driven(
    records: &ExcitedRecords,
    driven: &Driven,
    study: &Study,
    tell: &dyn Tell,
) -> Result<Made, Failed> {
    let names = &study.rig.microphones.names;
    let n = names.len();
    let made = Records { records, driven, names };
    let is_whole = matches!(driven.spectra, SpectraKind::Whole { .. });
    let table = if is_whole { "sweep" } else { "random" };
    let (gains, pairs, mut files) = gains_of(&made, study, table, tell)?;
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
        points.push(tell_heard(point, &heard, names, is_whole, tell));
        let Some(specimen) = &driven.transmission else { continue };
        let (text, bands) = transmission(&heard, specimen, study, index, (records, table))?;
        files.push((format!("transmission/{point}.csv"), text));
        let is_specimen = specimen.points.contains(point);
        bands.iter().for_each(|band| tell_band(point, band, is_specimen, tell));
        let numbers = |b: &LossBand| {
            [
                b.from_to_hz[0],
                b.from_to_hz[1],
                b.loss_db[0],
                b.loss_db[1],
                b.energy,
                b.through[0],
                b.through[1],
            ]
        };
        let kept = if is_specimen { &mut losses } else { &mut checks };
        kept.push(json!({ "point": point, "bands": bands.iter().map(numbers).collect::<Vec<_>>() }));
    }
    toml += "[response.columns]\n\"f [Hz]\" = \"f\"\n";
    // The errors of two channels' spectra are those of their ratio: the noise of a stage stands for them.
    let ends: &[&str] = if is_whole || n > 2 { &["re", "im", "sd"] } else { &["re", "im"] };
    for name in names {
        ends.iter().for_each(|end| toml += &format!("{name}_{end} = \"{name}_{end}\"\n"));
    }
    files.push(("observations.toml".to_owned(), toml));
    let answer = json!({ "pairs": pairs, "points": points, "transmission": losses, "empty": checks });
    Ok((files, answer))
}

/// The gains of the channels; what is said of the pairs that were switched, and files of it. `table` is the
/// table of the manifest.
fn gains_of(
    made: &Records<'_>,
    study: &Study,
    table: &str,
    tell: &dyn Tell,
) -> Result<(ChannelGains, Vec<Value>, Files), Failed> {
    let Records { records, driven, names } = *made;
    let n = names.len();
    if let Some(strange) = driven.switched.iter().find(|s| !(1..n).contains(&s.channel)) {
        return Err(Failed::bad_input(format!(
            "[[{table}.switched]]: channel {} of {}",
            strange.channel, strange.file
        ))
        .at(&records.path)
        .remedy(format!(
            "Give a channel from 1 to {}: the one that changed places with channel 0.",
            n.saturating_sub(1)
        )));
    }
    if !driven.straight.is_empty() {
        let gains = made.switched()?;
        let pairs = pairs_of(&gains, names, tell);
        switched::say_inverted(&gains, driven, names, tell);
        let file = ("gains.csv".to_owned(), gains_table(&gains, names));
        return Ok((ChannelGains::Switched(gains), pairs, vec![file]));
    }
    let Some(stated) = driven.stated(n, &records.path).or_bad_input()? else {
        tell.note("warning: the channels are taken to have the same gain, without error: add `straight` and `switched` records, or `[microphones]` with gains and their errors".to_owned());
        return Ok((ChannelGains::Equal, Vec::new(), Vec::new()));
    };
    // Spectra of two channels are written without the errors of the gains.
    let is_whole = matches!(driven.spectra, SpectraKind::Whole { .. });
    if !is_whole && n < 3 && study.rig.microphones.channel_errors().is_none() {
        tell.note("warning: stages do not count the errors of the gains that the manifest states: give `gain_sd` and `delay_sd` in [microphones] of rig.toml too".to_owned());
    }
    Ok((ChannelGains::Stated(stated), Vec::new(), Vec::new()))
}

/// Says what passes a specimen, or the empty tube, in a band of frequencies.
fn tell_band(point: &str, band: &LossBand, is_specimen: bool, tell: &dyn Tell) {
    let ([from, to], [loss, sd], [down, up]) = (band.from_to_hz, band.loss_db, band.through);
    tell.say(if is_specimen {
        format!(
            "{point}, {from:.0} to {to:.0} Hz: transmission loss {loss:.2} +- {sd:.2} dB, energy {:.3}",
            band.energy
        )
    } else {
        format!(
            "{point}, {from:.0} to {to:.0} Hz: energy {:.3}, through it downstream {down:.3} and upstream {up:.3}",
            band.energy
        )
    });
}

/// Says what was heard at an operating point, and which microphones heard little of it. Of sounds that are
/// heard whole (`is_whole`) it says how many frequencies were left out. Returns the same as JSON.
fn tell_heard(
    point: &str,
    heard: &RelativePressures,
    names: &[String],
    is_whole: bool,
    tell: &dyn Tell,
) -> Value {
    let (used, left_out, middle) = (heard.frequency_hz.len(), heard.left_out, heard.median_sd());
    let of = if is_whole { format!(" of {}", used + left_out) } else { String::new() };
    tell.say(format!("{point}: {used}{of} frequencies, relative standard deviation {middle:.1e} (median)"));
    for (name, share) in names.iter().zip(&heard.of_the_source).filter(|(_, share)| **share < HEARS_LITTLE) {
        tell.note(format!(
            "warning: {point}: {:.0} % of what {name} measures is the sound that the microphones have in common (median over the frequencies): if it is dead, \
             leave it out of rig.toml and `channels`",
            100.0 * share
        ));
    }
    json!({ "point": point, "frequencies": used, "left_out": left_out, "relative_sd": middle })
}

/// The channels of a record as its microphones are called.
pub(crate) fn microphones(names: &[String]) -> Vec<Channel> {
    let all = names.iter().cloned().enumerate();
    all.map(|(number, name)| Channel::Microphone { number, name: name.into() }).collect()
}

/// The channels of a record of which none is clipped; `names` are those of as many as have one.
///
/// # Errors
/// As of reading; a clipped channel.
pub(crate) fn unclipped(
    records: &ExcitedRecords,
    file: &str,
    count: Option<usize>,
    names: &[String],
) -> Result<Vec<Vec<f64>>, Failed> {
    let record = records.read(file, count).or_bad_input()?;
    let name = |m: usize| names.get(m).cloned().unwrap_or_else(|| format!("channel {}", m + 1));
    let clipped: Vec<String> = (0..record.channels.len())
        .map(|m| (m, record.clipped(m)))
        .filter(|(_, count)| *count > FULL)
        .map(|(m, count)| format!("{} of {}", counted(count, "sample"), name(m)))
        .collect();
    if clipped.is_empty() {
        return Ok(record.channels);
    }
    Err(Failed::bad_input(format!("{file}: clipped, {} at full scale", clipped.join(", ")))
        .at(&records.path)
        .remedy("Record it again with less gain, or take it out of the manifest."))
}

/// The records of a manifest, on their way to spectra.
struct Records<'a> {
    records: &'a ExcitedRecords,
    driven: &'a Driven,
    names: &'a [String],
}

impl Records<'_> {
    fn read(&self, file: &str) -> Result<Vec<Vec<f64>>, Failed> {
        unclipped(self.records, file, Some(self.names.len()), self.names)
    }

    /// A fault of records as a failure.
    fn fault(&self, files: &[String], fault: Fault) -> Failed {
        let fault = fault.called(&microphones(self.names));
        let listed = files.join(", ");
        if let Fault::DeadChannel { channel, span, median } = &fault {
            let what = format!(
                "{listed}: {channel} is missing: its samples span {span:.1e}, the median of the channels {median:.1e}"
            );
            let name = &self.names[channel.number()];
            let remedy = format!(
                "Look after its microphone and cable and record again, or leave {name} out of rig.toml and `channels`."
            );
            return Failed::bad_input(what).at(&self.records.path).remedy(remedy);
        }
        let remedy = match (&fault, self.driven.spectra) {
            (_, SpectraKind::Segments { .. }) => format!("Look at {listed}, or shorten `segment`."),
            _ => format!("Look at {listed}, or change `band_hz`, `resolution_hz` or `period`."),
        };
        Failed::bad_input(format!("{listed}: {fault}")).at(&self.records.path).remedy(remedy)
    }

    fn swept(&self, files: &[String], resolution_hz: f64, period: Option<usize>) -> Result<Swept, Failed> {
        let all = files.iter().map(|file| self.read(file)).collect::<Result<Vec<_>, _>>()?;
        let length = |record: &Vec<Vec<f64>>| record.first().map_or(0, Vec::len);
        let other = all.iter().position(|record| length(record) != length(&all[0]));
        // Of a sound that repeats itself a file may hold more periods than another.
        if let Some(k) = other.filter(|_| period.is_none()) {
            let what = format!(
                "{} has {} samples and {} has {}: all records of one point are repeats of one sound",
                files[k],
                length(&all[k]),
                files[0],
                length(&all[0])
            );
            return Err(Failed::bad_input(what)
                .at(&self.records.path)
                .remedy("Cut all files to one length, from the same moment of the sound on."));
        }
        let options = SweptOptions { band_hz: self.records.band_hz, resolution_hz, period };
        Swept::new(&all, self.records.rate_hz, &options).map_err(|fault| self.fault(files, fault))
    }

    fn spectra(&self, files: &[String]) -> Result<Spectra, Failed> {
        match self.driven.spectra {
            SpectraKind::Whole { resolution_hz, period, .. } => {
                Ok(self.swept(files, resolution_hz, period)?.spectra)
            }
            SpectraKind::Segments { segment } => {
                let channels = files.first().map(|file| self.read(file)).transpose()?.unwrap_or_default();
                Spectra::welch(&channels, self.records.rate_hz, segment, self.records.band_hz)
                    .map_err(|fault| self.fault(files, fault))
            }
        }
    }

    /// Gains from records in which channels have changed places.
    fn switched(&self) -> Result<SwitchedGains, Failed> {
        let straight = self.spectra(&self.driven.straight)?;
        let one =
            |s: &rijke_rig::SwitchedRecord| Ok((s.channel, self.spectra(std::slice::from_ref(&s.file))?));
        let switched: Vec<(usize, Spectra)> =
            self.driven.switched.iter().map(one).collect::<Result<_, Failed>>()?;
        let polynomials = self.driven.polynomials;
        let gains = SwitchedGains::new(&straight, &switched, self.names.len(), polynomials)
            .map_err(|fault| Failed::bad_input(fault).at(&self.records.path))?;
        match gains.doubt(&straight, &switched, polynomials) {
            Some(doubt) => Err(switched::failure(&doubt, self.driven, self.names).at(&self.records.path)),
            None => Ok(gains),
        }
    }

    /// What the microphones hear in the records of an operating point.
    fn heard(&self, files: &[String], gains: &ChannelGains) -> Result<RelativePressures, Failed> {
        let SpectraKind::Whole { resolution_hz, period, coherence } = self.driven.spectra else {
            return Ok(RelativePressures::of_noise(self.spectra(files)?, self.names.len(), gains));
        };
        let found = self.swept(files, resolution_hz, period)?;
        RelativePressures::of_sweeps(&found, coherence, gains).map_err(|fault| {
            let remedy = match fault {
                PressureFault::OtherLength => {
                    "Record all sweeps for the same time, or cut the files to one length."
                }
                PressureFault::Incoherent { .. } => {
                    "Look whether `band_hz` holds the frequencies of the sweep; drive it longer or louder, or lower `coherence`."
                }
                _ => "Look at these files.",
            };
            let what = format!("{}: {fault}", files.join(", "));
            Failed::bad_input(what).at(&self.records.path).remedy(remedy)
        })
    }
}

/// Says what the gains are, and how far their estimates lie from each other.
fn pairs_of(gains: &SwitchedGains, names: &[String], tell: &dyn Tell) -> Vec<Value> {
    let mut pairs = Vec::new();
    for (c, name) in names.iter().enumerate().skip(1) {
        let of = gains.pairs.iter().filter(|p| p.channel == c);
        let told: Vec<String> =
            of.clone().map(|p| format!("{} {:.1e} +- {:.1e}", names[p.by], p.distance, p.sd)).collect();
        let middle = gains.gains[c].len() / 2;
        let g = gains.gains[c][middle];
        tell.say(format!(
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
    heard: &RelativePressures,
    specimen: &Specimen,
    study: &Study,
    point: usize,
    (records, table): (&ExcitedRecords, &str),
) -> Result<(String, Vec<LossBand>), Failed> {
    let layout = study.rig.at_factors(&study.campaign.points[point].factors, study.rig.temperature);
    let layout = layout.map_err(|problem| {
        Failed::bad_input(problem)
            .at(&study.folder.join("rig.toml"))
            .remedy("Correct rig.toml, or the factors of this point in campaign.csv.")
    })?;
    if let Some(part) = study.rig.parts.iter().find(|part| part.is_of_other_gas()) {
        return Err(Failed::bad_input(format!(
            "`{}` has a gas of its own, and transmission is computed for one gas",
            part.name
        ))
        .at(&study.folder.join("rig.toml"))
        .remedy("Take gamma and gas_constant out of the ducts; [gas] has those of all."));
    }
    let gas = study.rig.gas.at(study.rig.temperature, study.rig.pressure);
    let duct = |d: &DuctAt| TubeDuct { span: d.span, area: d.area };
    let ducts: Vec<TubeDuct> = layout.ducts.iter().map(duct).collect();
    let tube = TransmissionTube::of(specimen, layout.microphones, &ducts, &gas);
    let errors = TubeErrors::of(specimen);
    let [before, behind] = tube.sides();
    if before < 2 || behind < 2 {
        return Err(Failed::bad_input(format!(
            "`between` of [{table}.transmission] has {before} microphones upstream of the specimen and {behind} downstream of it; two or more on each side are needed to separate the waves"
        ))
        .at(&records.path)
        .remedy("Correct `between`, or the places of the microphones in rig.toml."));
    }
    let losses = tube.losses(heard, &errors);
    let mut text =
        "f [Hz],loss [dB],loss_sd [dB],energy,downstream_re,downstream_im,upstream_re,upstream_im\n"
            .to_owned();
    for TransmissionLoss { frequency_hz, loss_db: [loss, sd], transmitted } in &losses {
        let ([down, up], energy) = (transmitted.through, transmitted.energy);
        text += &format!("{frequency_hz},{loss},{sd},{energy},{},{},{},{}\n", down.re, down.im, up.re, up.im);
    }
    Ok((text, LossBand::of(&losses)))
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
