//! Any text as the campaign of a study.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rijke_fuzz::study;

fuzz_target!(|text: &str| {
    let _ = study("campaign.csv", text);
});
