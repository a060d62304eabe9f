//! Any bytes as a record in text, and what signal processing makes of it if it is one.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rijke_rig::{Arrays, Layout, inspect, read_record};
use rijke_signal::{ClickOptions, PingOptions, Trace, fit_click, fit_ping};

fuzz_target!(|bytes: &[u8]| {
    let path = std::env::temp_dir().join(format!("rijke-fuzz-{}.csv", std::process::id()));
    let _ = std::fs::remove_file(&path); // written over, it would go to the disk at once
    if std::fs::write(&path, bytes).is_err() {
        return;
    }
    let channels = [Some(0), Some(1)];
    let layout = Layout { channels: &channels, full_scale: 20.0, rate_hz: 1e4, quiet: 2, arrays: &Arrays::default() };
    let _ = inspect(&path);
    if let Ok(record) = read_record(&path, layout) {
        let trace = Trace::from(&record);
        let _ = fit_ping(&trace, &PingOptions::default());
        let _ = fit_click(&trace, &ClickOptions::default());
    }
});
