//! Any text as the manifest of records of random noise, sweeps or blows.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rijke_fuzz::{folder, replace};
use rijke_rig::ExcitedRecords;

fuzz_target!(|text: &str| {
    let Ok(folder) = folder("excited") else { return };
    if replace(&folder.join("manifest.toml"), text.as_bytes()).is_ok() {
        let _ = ExcitedRecords::open(&folder);
    }
});
