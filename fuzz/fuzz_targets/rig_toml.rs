//! Any text as the rig of a study.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rijke_fuzz::study;

fuzz_target!(|text: &str| {
    let Some(study) = study("rig.toml", text) else { return };
    for point in &study.campaign.points {
        let _ = study.rig.at(point, 293.15);
    }
    let _ = study.apparatus();
});
