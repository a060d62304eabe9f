//! Any text as the readings of thermometers.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rijke_fuzz::study;
use rijke_study::read_readings;

fuzz_target!(|text: &str| {
    if let Some(study) = study("observations/readings.csv", text) {
        let _ = read_readings(&study.folder.join("observations/readings.csv"), &study.campaign);
    }
});
