//! Any bytes as a WAV file of two microphones.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rijke_rig::{Arrays, Layout, inspect, read_record};

fuzz_target!(|bytes: &[u8]| {
    let path = std::env::temp_dir().join(format!("rijke-fuzz-{}.wav", std::process::id()));
    let _ = std::fs::remove_file(&path); // written over, it would go to the disk at once
    if std::fs::write(&path, bytes).is_err() {
        return;
    }
    let channels = [Some(1), Some(0)];
    let layout = Layout { channels: &channels, full_scale: 20.0, rate_hz: 1e4, quiet: 2, arrays: &Arrays::default() };
    let _ = read_record(&path, layout);
    let _ = inspect(&path);
});
