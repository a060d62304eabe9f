//! Any bytes as a WAV file of two microphones.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rijke_fuzz::{file, layout};
use rijke_rig::{Arrays, Reading, inspect, read_record};

fuzz_target!(|bytes: &[u8]| {
    let Ok(path) = file("record.wav", bytes) else { return };
    let channels = [Some(1), Some(0)];
    let _ = read_record(&path, layout(&channels, &Arrays::default(), &Reading::default()));
    let _ = inspect(&path);
});
