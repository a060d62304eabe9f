//! The laboratory's bad records against what signal processing says of them: each rejected or corrected with the right
//! reason, and sound records kept.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test may fail by panicking and prints its table"
)]

use rijke_lab::{Fault, Truth, VirtualRig};
use rijke_rig::{Campaign, RecordSource, Rig};
use rijke_signal::{ProcessOptions, Processed, process};
use std::collections::BTreeMap;

/// Name of a fault, and the words that tell it in a rejection or correction.
fn kind(fault: Fault) -> (&'static str, &'static [&'static str]) {
    match fault {
        Fault::Clipped => ("clipped", &["is clipped"]),
        Fault::Dead(_) => ("missing channel", &["is missing", "carries no signal", "holds no impulse"]),
        Fault::DoubleTrigger(_) => ("double trigger", &["second excitation"]),
        Fault::Dropout(..) => ("dropout", &["drops out"]),
        Fault::HumBurst(..) => ("hum burst", &["hum burst"]),
        Fault::WrongPolarity(_) => ("wrong polarity", &["opposite polarity"]),
    }
}

/// Of one kind of bad record: how many there are, rejected with the right reason, corrected, rejected with another
/// reason, and accepted.
#[derive(Clone, Copy, Default)]
struct Count {
    all: u32,
    right: u32,
    corrected: u32,
    wrong: u32,
    missed: u32,
}

/// What became of one record.
fn judge(done: &Processed, name: &str, fault: Option<Fault>, counts: &mut BTreeMap<&'static str, Count>) {
    let find =
        |list: &[rijke_rig::Rejection]| list.iter().find(|r| r.record == name).map(|r| r.reason.clone());
    let (rejected, corrected) = (find(&done.observations.rejections), find(&done.corrections));
    let (label, words) = fault.map_or(("sound", [].as_slice()), kind);
    let count = counts.entry(label).or_default();
    count.all += 1;
    let told = |reason: &str| words.iter().any(|w| reason.contains(w));
    match (&rejected, &corrected) {
        (Some(reason), _) if told(reason) => count.right += 1,
        (Some(reason), _) => {
            count.wrong += 1;
            println!("{name}: {label}, rejected: {reason}");
        }
        (None, Some(reason)) if told(reason) => count.corrected += 1,
        (None, Some(reason)) => {
            count.wrong += 1;
            println!("{name}: {label}, corrected: {reason}");
        }
        (None, None) => {
            count.missed += 1;
            if let Some(fault) = fault {
                println!("{name}: accepted in spite of {fault:?}");
            }
        }
    }
}

/// `REPEATS`, `SEED` and `ROWS` (with commas) of the environment choose the records.
#[test]
#[ignore = "long: the whole campaign of raw records, some two minutes"]
fn lab_bad_records_are_told_and_sound_ones_kept() {
    let number = |name: &str, default: u32| std::env::var(name).map_or(default, |v| v.parse().unwrap());
    let rows: Vec<String> =
        std::env::var("ROWS").map_or(Vec::new(), |v| v.split(',').map(str::to_owned).collect());
    let (rig, campaign) = (Rig::juniper_yoko_2022(), Campaign::juniper_yoko_2022());
    let repeats = number("REPEATS", 40);
    let mut truth = Truth::standard();
    if let Ok(share) = std::env::var("BAD") {
        (truth.faults.pings, truth.faults.clicks) = (share.parse().unwrap(), share.parse().unwrap());
    }
    let lab =
        VirtualRig::new(&rig, &campaign, &truth, &rows, Some(repeats), u64::from(number("SEED", 1))).unwrap();
    let done = process(&lab, &ProcessOptions::default(), &|| ()).unwrap();
    for which in ["pings", "clicks"] {
        let mut counts = BTreeMap::new();
        for (k, point) in lab.set().points.iter().enumerate() {
            let names = if which == "pings" { &point.pings } else { &point.clicks };
            for (n, name) in names.iter().enumerate() {
                let fault = if which == "pings" { lab.ping_fault(k, n) } else { lab.click_fault(k, n) };
                judge(&done, name, fault, &mut counts);
            }
        }
        println!("{which}: kind, records, right reason, corrected, wrong reason, accepted");
        for (label, c) in &counts {
            println!("{label}: {} {} {} {} {}", c.all, c.right, c.corrected, c.wrong, c.missed);
        }
        let sound = counts["sound"];
        assert!(100 * sound.wrong < sound.all, "{} of {} sound {which} rejected", sound.wrong, sound.all);
        assert!(counts.iter().all(|(label, c)| *label == "sound" || c.missed == 0), "a bad record passed");
    }
}
