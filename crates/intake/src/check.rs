//! The records of a folder, every sample of every file, before any work.

use crate::excited::{Checked, Excited};
use crate::{Intake, OpenStudy};
use rayon::prelude::*;
use rijke_numerics::words::{counted, few};
use rijke_numerics::{Failed, Tell};
use rijke_rig::{DataKind, Record, RecordSet, Rejection, RigError};
use serde_json::{Value, json};
use std::path::Path;

/// At most this many faults of files are listed.
const MOST: usize = 20;

/// Reads every record of a folder, and says what it holds.
///
/// # Errors
/// Files that cannot be read or processed, with the remedy.
pub fn check_records(dir: &Path, open: OpenStudy<'_>, tell: &dyn Tell) -> Result<Value, Failed> {
    match Excited::checked(dir, open)? {
        Some(Checked::Records(files)) => {
            tell.say(format!(
                "{files} records of random noise, sweeps or blows, all of which can be processed"
            ));
            return Ok(json!({ "records": files }));
        }
        Some(Checked::Elsewhere(warning)) => {
            tell.note(format!("warning: {warning}"));
            tell.say("the records were not checked".to_owned());
            return Ok(json!({ "records": null }));
        }
        None => {}
    }
    let intake = Intake::open(dir, open)?;
    let (source, set) = (intake.source(), intake.source().set());
    let records = set.items();
    let done = tell.progress("reading", records.len() as u64);
    let read: Vec<Result<usize, RigError>> = records
        .par_iter()
        .map(|record| {
            let samples = record.read(source);
            done(1);
            samples.map(|r| clipped(&r))
        })
        .collect();
    drop(done);

    let wrong: Vec<_> = read.iter().filter_map(|r| r.as_ref().err()).collect();
    if !wrong.is_empty() {
        let are = if wrong.len() == 1 { "file is" } else { "files are" };
        let text = format!("{} of {} {are} wrong\n{}", wrong.len(), read.len(), by_fault(&wrong).join("\n"));
        return Err(Failed::bad_input(text)
            .at(dir)
            .remedy("Mend each file as its line says, or take it out of the manifest; then check again."));
    }
    intake.twins()?.into_iter().for_each(|said| tell.note(said));
    describe(set, tell);
    for (record, clipped) in records.iter().zip(read.iter().flatten()).filter(|(_, c)| **c > 0) {
        tell.say(format!(
            "clipped: {} ({} at full scale); `rijke process` leaves that channel out, or rejects the record",
            record.name(set),
            counted(*clipped, "sample")
        ));
    }
    let clipped = records.iter().zip(read.iter().flatten()).filter(|(_, c)| **c > 0);
    let clipped: Vec<_> = clipped.map(|(r, c)| json!({ "file": r.name(set), "samples": c })).collect();
    let rejected = intake.rejected_of_few()?;
    for Rejection { record, reason } in &rejected {
        tell.note(format!("warning: `rijke process` will reject {record}: {reason}"));
    }
    let rejected: Vec<_> = rejected.iter().map(|r| json!({ "file": r.record, "reason": r.reason })).collect();
    let answer = json!({
        "rig": set.rig.name, "kind": set.kind, "source": set.source, "points": set.points.len(), "days": set.days.len(),
        "pings": set.points.iter().map(|p| p.pings.len()).sum::<usize>(),
        "clicks": set.points.iter().map(|p| p.clicks.len()).sum::<usize>(), "clipped": clipped, "rejected": rejected,
    });
    Ok(answer)
}

/// How many samples of a record are at the limit of the instrument.
fn clipped(record: &Record) -> usize {
    (0..record.channels.len()).map(|m| record.clipped(m)).sum()
}

fn describe(set: &RecordSet, tell: &dyn Tell) {
    let kind = match set.kind {
        DataKind::Measured => "measured",
        DataKind::Virtual => "virtual",
    };
    tell.say(format!("{}: {kind} data, {}", set.rig.name, set.source));
    let pings: usize = set.points.iter().map(|p| p.pings.len()).sum();
    let clicks: usize = set.points.iter().map(|p| p.clicks.len()).sum();
    tell.say(format!(
        "{} on {}: {} at {} Hz, {} at {} Hz",
        counted(set.points.len(), "operating point"),
        counted(set.days.len(), "day"),
        counted(pings, "ping"),
        set.ping.rate_hz,
        counted(clicks, "click"),
        set.click.rate_hz
    ));
    for calibration in &set.calibrations {
        tell.say(format!(
            "{} at {} Hz on {}",
            counted(calibration.clicks.len(), "calibration click"),
            calibration.stretch.rate_hz,
            set.days[calibration.day].id
        ));
    }
}

/// Every fault once, by the first file that has it, with the other files that do. A fault is what stands
/// behind the name of the file.
fn by_fault(wrong: &[impl ToString]) -> Vec<String> {
    let mut faults: Vec<(String, String, Vec<String>)> = Vec::new();
    for whole in wrong.iter().map(ToString::to_string) {
        let (file, fault) = whole.split_once(": ").unwrap_or(("", &whole));
        match faults.iter_mut().find(|(_, known, _)| known == fault) {
            Some((.., files)) => files.push(file.to_owned()),
            None => faults.push((whole.clone(), fault.to_owned(), Vec::new())),
        }
    }
    let rest = faults.len().saturating_sub(MOST);
    let said = faults.into_iter().take(MOST).map(|(first, _, others)| match others.len() {
        0 => first,
        n => format!("{first}\n  the same of {}: {}", counted(n, "other file"), few(&others, 3)),
    });
    said.chain((rest > 0).then(|| format!("and {}", counted(rest, "other fault")))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn message_a_fault_of_several_files_is_said_once() {
        let wrong =
            ["a.wav: no full scale", "b.wav: no full scale", "c.wav: not a WAV file", "d.wav: no full scale"];
        let said = by_fault(&wrong);
        assert_eq!(
            said,
            ["a.wav: no full scale\n  the same of 2 other files: b.wav, d.wav", "c.wav: not a WAV file"]
        );
        let many: Vec<String> = (0..25).map(|k| format!("{k}.wav: fault {k}")).collect();
        assert_eq!(by_fault(&many).last().unwrap(), "and 5 other faults");
    }
}
