//! Any six texts, separated by form feeds, as a folder of OSCILOS_lite inputs.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rijke_network::file::{OscilosTexts, read_oscilos};

fuzz_target!(|text: &str| {
    let mut texts = text.split('\u{c}').map(str::to_owned);
    let mut next = || texts.next().unwrap_or_default();
    let texts = OscilosTexts {
        geometry: next(),
        mean_flow: next(),
        inlet: next(),
        outlet: next(),
        scan_range: next(),
        flame: Some(next()),
    };
    let _ = read_oscilos(&texts);
});
