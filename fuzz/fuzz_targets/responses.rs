//! Any two texts, separated by a form feed, as the declaration of responses and the file of numbers that it
//! names `r.csv`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rijke_fuzz::{replace, study};

fuzz_target!(|text: &str| {
    let (declared, numbers) = text.split_once('\u{c}').unwrap_or((text, ""));
    if let Some(study) = study("observations/r.csv", numbers)
        && replace(&study.folder.join("observations/observations.toml"), declared.as_bytes()).is_ok()
    {
        let _ = study.responses();
    }
});
