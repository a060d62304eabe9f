//! Any six texts, separated by form feeds, as a folder of OSCILOS_lite inputs: read it, and find the modes of
//! what is small enough to be quick.
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
    if let Ok((chain, region)) = read_oscilos(&texts)
        && chain.ducts().len() <= 200
        && chain.travel_time() * region.omega[1] < 300.0
    {
        let _ = chain.modes(&region);
    }
});
