//! Any text as the base states of a study.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rijke_fuzz::study;
use rijke_study::read_states;

fuzz_target!(|text: &str| {
    if let Some(study) = study("base/states.json", text) {
        let _ = read_states(&study.folder.join("base/states.json"), &study.rig);
    }
});
