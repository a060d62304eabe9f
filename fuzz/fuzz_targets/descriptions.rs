//! Any text as each of the files of a folder of records that are written by hand: rig, campaign, manifest.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rijke_fuzz::{folder, replace};
use rijke_rig::{Apparatus, RecordFolder};
use std::{fs, path::Path};

const RIG: &str = include_str!("../../crates/rig/data/rig.toml");
const MANIFEST: &str = "rig = 'rig.toml'\ncampaign = 'campaign.csv'\nkind = 'measured'\nsource = 'fuzz'\nchannels = []\n\
    ping = { rate_hz = 1e4, quiet_samples = 1 }\nday = []\npoint = []\n";
const CAMPAIGN: &str = include_str!("../../crates/rig/data/campaign.csv");

fuzz_target!(|text: &str| {
    let _ = Apparatus::parse(text, Path::new("rig.toml"));
    let Ok(folder) = folder("descriptions") else { return };
    if !folder.join("rig.toml").exists() {
        let _ = fs::write(folder.join("rig.toml"), RIG);
        let _ = fs::write(folder.join("campaign.csv"), CAMPAIGN);
    }
    let _ = replace(&folder.join("manifest.toml"), text.as_bytes());
    let _ = RecordFolder::open(&folder);
    let _ = replace(&folder.join("manifest.toml"), MANIFEST.as_bytes());
    let _ = replace(&folder.join("campaign.csv"), text.as_bytes());
    let _ = RecordFolder::open(&folder);
    let _ = replace(&folder.join("campaign.csv"), CAMPAIGN.as_bytes());
});
