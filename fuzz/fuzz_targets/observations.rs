//! Any five texts, separated by form feeds, as the tables of a folder of observations: points, pings, clicks,
//! rejections, and what is left of the channels.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rijke_fuzz::{folder, replace};
use rijke_rig::Observations;
use std::fs;

const RIG: &str = include_str!("../../crates/rig/data/rig.toml");
const HEAD: &str = "rig = \"rig.toml\"\nkind = \"measured\"\nsource = \"fuzz\"\n";

fuzz_target!(|text: &str| {
    let Ok(folder) = folder("observations") else { return };
    let mut texts = text.split('\u{c}');
    for name in ["points.csv", "pings.csv", "clicks.csv", "rejections.csv", "channels.toml"] {
        let path = folder.join(name);
        let _ = texts.next().map_or_else(|| fs::remove_file(&path), |text| replace(&path, text.as_bytes()));
    }
    // One microphone: two columns are a ping.
    let (head, rest) = RIG.split_once("positions = [").unwrap_or_default();
    let rest = rest.split_once(']').unwrap_or_default().1.replacen("reference = 5", "reference = 0", 1);
    if !folder.join("rig.toml").exists() {
        let _ = fs::write(folder.join("rig.toml"), format!("{head}positions = [0.75]{rest}"));
        let _ = fs::write(folder.join("observations.toml"), HEAD);
    }
    let _ = Observations::read(&folder);
});
