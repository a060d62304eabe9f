//! Any text as the observations of a study.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rijke_fuzz::study;

fuzz_target!(|text: &str| {
    if let Some(study) = study("observations/modes.csv", text) {
        let _ = study.observations();
    }
});
