//! Any text as each of the files of a folder of records that are written by hand: rig, campaign, manifest.
#![no_main]

use libfuzzer_sys::fuzz_target;
use rijke_fuzz::{folder, replace};
use rijke_rig::{Campaign, RecordFolder, Rig};
use std::{fs, path::Path};

const RIG: &str = include_str!("../../crates/rig/data/rigs/juniper-yoko-2022.toml");
const CAMPAIGN: &str = include_str!("../../crates/rig/data/campaigns/juniper-yoko-2022.toml");

fuzz_target!(|text: &str| {
    let _ = Rig::parse(text, Path::new("rig.toml"));
    if let Ok(campaign) = Campaign::parse(text, Path::new("campaign.toml")) {
        let _ = campaign.to_toml();
    }
    let Ok(folder) = folder("descriptions") else { return };
    if !folder.join("rig.toml").exists() {
        let _ = fs::write(folder.join("rig.toml"), RIG);
        let _ = fs::write(folder.join("campaign.toml"), CAMPAIGN);
    }
    let _ = replace(&folder.join("manifest.toml"), text.as_bytes());
    let _ = RecordFolder::open(&folder);
});
