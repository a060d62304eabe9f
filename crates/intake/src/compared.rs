//! Records in which all microphones hear the same pressure: a table of their gains and delays.

use crate::driven::{microphones, unclipped};
use rijke_numerics::{Classify, Failed, StagedFolder, Tell, write_within};
use rijke_rig::{Comparison, ExcitedRecords};
use rijke_signal::{ComparedChannels, ComparisonFault};
use rijke_study::Study;
use serde_json::{Value, json};
use std::path::Path;

/// What is written.
const TABLE: &str = "microphones.csv";
/// Change of a gain over the band that is told.
const BENT: f64 = 0.005;

pub(crate) fn run(
    records: &ExcitedRecords,
    comparison: &Comparison,
    study: &Study,
    out: &Path,
    force: bool,
    tell: &dyn Tell,
) -> Result<Value, Failed> {
    let folder = StagedFolder::beside_others(out, TABLE, &[TABLE], force)?;
    let found = compared(records, comparison, study)?;
    let names = &study.rig.microphones.names;
    let c = &found.channels;
    let mut text = "microphone,gain [1],gain_sd [1],delay [s],delay_sd [s]\n".to_owned();
    let mut rows = Vec::new();
    for (m, name) in names.iter().enumerate() {
        let (gain, delay) = ([c.gains[m], c.gain_sds[m]], [c.delays[m], c.delay_sds[m]]);
        text += &format!("{m},{},{:e},{:e},{:e}\n", gain[0], gain[1], delay[0], delay[1]);
        rows.push(
            json!({ "microphone": name, "gain": gain, "delay": delay, "coherence": found.coherence[m] }),
        );
        if found.silent.contains(&m) {
            tell.note(format!(
                "{name} gave nothing in any record, and nothing is known of it: write `dead = [{m}]` in the manifest of the pings"
            ));
            continue;
        }
        tell.say(format!(
            "{name}: gain {:.5} +- {:.5}, delay {:.2} +- {:.2} us, coherence {:.4}",
            gain[0],
            gain[1],
            1e6 * delay[0],
            1e6 * delay[1],
            found.coherence[m]
        ));
        if gain[0] < 0.0 {
            tell.note(format!(
                "{name} has the opposite polarity of the reference: its gain is written as negative"
            ));
        }
        if found.bend[m] > BENT {
            tell.note(format!(
                "warning: the gain of {name} changes by {:.1} % over the band, which is part of its error: is the pressure the same at all microphones up to {} Hz?",
                100.0 * found.bend[m],
                records.band_hz[1]
            ));
        }
    }
    if comparison.unequal == [0.0; 2] {
        tell.note("the pressure is taken to be the same at all microphones; what makes it unequal can be stated: gain_sd and delay_sd in [comparison]".to_owned());
    }
    write_within(folder.path(), TABLE, text)?;
    folder.commit()?;
    tell.say(format!(
        "Written to {}. In the manifest of the pings: [microphones] with table = \"PATH/{TABLE}\".",
        out.join(TABLE).display()
    ));
    Ok(json!({ "table": out.join(TABLE), "microphones": rows }))
}

/// Gains and delays of the microphones of the study.
pub(crate) fn compared(
    records: &ExcitedRecords,
    comparison: &Comparison,
    study: &Study,
) -> Result<ComparedChannels, Failed> {
    let (count, reference) = (study.rig.microphones.names.len(), study.rig.microphones.reference);
    let sensitivities = comparison.sensitivities(count, &records.path).or_bad_input()?;
    let read = |file: &String| {
        let mut channels = unclipped(records, file, Some(count), &study.rig.microphones.names)?;
        for (channel, sensitivity) in channels.iter_mut().zip(&sensitivities) {
            channel.iter_mut().for_each(|v| *v /= sensitivity);
        }
        Ok(channels)
    };
    let all: Vec<_> = comparison.files.iter().map(read).collect::<Result<_, Failed>>()?;
    ComparedChannels::new(&all, records.rate_hz, records.band_hz, reference, comparison.unequal).map_err(|fault| {
        let (what, remedy) = match &fault {
            ComparisonFault::Record { file, fault } => (
                format!("{}: {}", comparison.files[*file], fault.clone().called(&microphones(&study.rig.microphones.names))),
                "Record some seconds of noise or of a slow sweep, without gaps, or narrow `band_hz`.".to_owned(),
            ),
            ComparisonFault::Incoherent { channel, coherence } => (
                format!(
                    "{} does not measure the same sound as the reference: their coherence is {coherence:.2} on average, and 0.5 is needed",
                    study.rig.microphones.names[*channel]
                ),
                "Drive louder, narrow `band_hz` to what the loudspeaker gives, or correct `channels`.".to_owned(),
            ),
            ComparisonFault::Turned { channel, file } => (
                format!(
                    "{} has one sign in {} and the other in {}: its cable was turned between them",
                    study.rig.microphones.names[*channel], comparison.files[0], comparison.files[*file]
                ),
                "Leave out the records of one of the two.".to_owned(),
            ),
            _ => (fault.to_string(), "Look at the files and at `channels`.".to_owned()),
        };
        Failed::bad_input(what).at(&records.path).remedy(remedy)
    })
}
