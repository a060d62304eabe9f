//! Any bytes as a record in text, and what signal processing makes of it if it is one.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rijke_fuzz::{file, layout};
use rijke_rig::{Arrays, Reading, inspect, read_record};
use rijke_signal::{ClickOptions, PingOptions, Trace, fit_click, fit_ping};

fuzz_target!(|bytes: &[u8]| {
    let Ok(path) = file("record.csv", bytes) else { return };
    let channels = [Some(0), Some(1)];
    let _ = inspect(&path);
    if let Ok(record) = read_record(&path, layout(&channels, &Arrays::default(), &Reading::default())) {
        let trace = Trace::from(&record);
        let _ = fit_ping(&trace, &PingOptions::default());
        let _ = fit_click(&trace, &ClickOptions::default());
    }
});
