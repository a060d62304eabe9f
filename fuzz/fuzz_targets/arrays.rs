//! Any bytes as a record in a file of named arrays: MATLAB 5, MATLAB 7.3 and HDF5, told apart by their first
//! bytes.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rijke_fuzz::{file, layout};
use rijke_rig::{Arrays, Reading, inspect, read_record};

fuzz_target!(|bytes: &[u8]| {
    let Ok(path) = file("record.mat", bytes) else { return };
    let channels = [Some(0), Some(1)];
    for names in [&[][..], &["p"], &["left", "right"], &["run.left", "run.right"]] {
        let names = names.iter().map(|n| (*n).to_owned()).collect();
        let arrays = Arrays { names, rate: None };
        let _ = read_record(&path, layout(&channels, &arrays, &Reading::default()));
    }
    let _ = inspect(&path);
});
