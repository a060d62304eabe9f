//! Any bytes as a table of numbers, and as a record in text with names, time, units and a dead microphone.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rijke_fuzz::{file, layout};
use rijke_rig::{Arrays, Columns, Reading, Unit, read_record};

fuzz_target!(|bytes: &[u8]| {
    let Ok(path) = file("table.csv", bytes) else { return };
    if let Ok(columns) = Columns::read(&path) {
        for name in columns.headings() {
            let _ = (columns.keys(name, "Pa"), columns.some_numbers(name, "s"), columns.words(name));
        }
    }
    let names = [("left", Some(0)), ("right", Some(1)), ("drive", None)];
    let reading = Reading {
        names: names.into_iter().map(|(name, m)| (name.to_owned(), m)).collect(),
        unit: Unit::parse("V").ok(),
        sensitivities: vec![0.05; 2],
        dead: vec![1],
        ..Reading::default()
    };
    let _ = read_record(&path, layout(&[], &Arrays::default(), &reading));
});
