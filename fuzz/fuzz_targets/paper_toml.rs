//! Any text as what was published of a study.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rijke_fuzz::study;

fuzz_target!(|text: &str| {
    let _ = study("paper.toml", text);
});
