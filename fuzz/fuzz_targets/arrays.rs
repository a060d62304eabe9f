//! Any bytes as a record in a file of named arrays: MATLAB 5, MATLAB 7.3 and HDF5, told apart by their first bytes.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rijke_rig::{Arrays, Layout, inspect, read_record};

fuzz_target!(|bytes: &[u8]| {
    let path = std::env::temp_dir().join(format!("rijke-fuzz-{}.mat", std::process::id()));
    let _ = std::fs::remove_file(&path); // written over, it would go to the disk at once
    if std::fs::write(&path, bytes).is_err() {
        return;
    }
    let channels = [Some(0), Some(1)];
    for names in [&[][..], &["p"], &["left", "right"], &["run.left", "run.right"]] {
        let names = names.iter().map(|n| (*n).to_owned()).collect();
        let arrays = Arrays { names, rate: None };
        let layout = Layout { channels: &channels, full_scale: 20.0, rate_hz: 1e4, quiet: 2, arrays: &arrays };
        let _ = read_record(&path, layout);
    }
    let _ = inspect(&path);
});
