//! Any text as a file of candidates.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rijke_fuzz::study;

fuzz_target!(|text: &str| {
    let Some(study) = study("candidates/tube.toml", text) else { return };
    for candidate in study.catalogue.candidates() {
        let units: Vec<&str> = candidate.parameters.iter().map(|p| p.unit.as_str()).collect();
        for effect in &candidate.effects {
            let _ = effect.law.unit_fault(&study.rig.scope, &units, "1");
        }
    }
});
