//! Offsets that drift during the record.

use crate::driven::Driven;
use crate::short::{Tally, any};

/// A slow curve from 0 to 1 over the record.
fn curve(kind: &str, t: f64) -> f64 {
    match kind {
        "a line" => t,
        "a warming amplifier" => 1.0 - (-3.0 * t).exp(),
        _ => 0.5 - 0.5 * (std::f64::consts::PI * t).cos(),
    }
}

#[test]
fn coverage_of_offsets_that_drift() {
    check(20);
}

#[test]
#[ignore = "long: 200 records of each of 9 kinds"]
fn coverage_of_offsets_that_drift_over_200_seeds() {
    check(200);
}

fn check(count: u64) {
    let rig = |seed| {
        let driven = any(seed, 5.0);
        Driven { ratio: driven.ratio.min(400.0), ..driven }
    };
    let bare = Tally::of(count, rig, |seed, driven| driven.fit(seed));
    for kind in ["a line", "a warming amplifier", "half a wave"] {
        for share in [0.01, 0.1, 0.3] {
            let tally = Tally::of(count, rig, |seed, driven| {
                let mut record = driven.record(seed);
                for y in &mut record {
                    let top = y.iter().fold(0.0_f64, |a, v| v.abs().max(a));
                    let length = y.len() as f64;
                    y.iter_mut()
                        .enumerate()
                        .for_each(|(n, v)| *v += share * top * curve(kind, n as f64 / length));
                }
                driven.fit_of(&record)
            });
            tally.show(&format!("{kind}, {share} of the amplitude"));
            assert!(tally.worst < 5.0 && tally.rms.iter().all(|r| *r < 1.45), "{kind} {share}");
            assert!(tally.used * 10 > bare.used * 7, "{kind} {share}: {} of {}", tally.used, bare.used);
        }
    }
}
