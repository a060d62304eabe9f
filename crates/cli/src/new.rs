//! `rijke new`: a folder to fill in.

use crate::{
    failure::{Classify, Failure},
    staging::StagedFolder,
    ui::Ui,
};
use rijke_rig::{Campaign, OperatingPoint};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Write a commented rig, campaign, manifest and candidate file for a tube with one heat source, to be filled in.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  rijke new my-rig\n  rijke check my-rig\n  rijke run my-rig\n\n\
    Tried without a rig, with records of the virtual laboratory:\n  \
    rijke lab --rig my-rig/rig.toml --campaign my-rig/campaign.toml --out records\n  rijke run records")]
pub(crate) struct Args {
    /// Folder to write.
    dir: PathBuf,
}

const RIG: &str = include_str!("new/rig.toml");
const CAMPAIGN: &str = include_str!("new/campaign.toml");
const CANDIDATES: &str = include_str!("new/candidates.toml");

/// The head of the manifest; the operating points follow.
const MANIFEST: &str = "\
# What was recorded. Paths are relative to this file. Each file, WAV or CSV, holds all microphones of one record.

rig = \"rig.toml\"
campaign = \"campaign.toml\"
kind = \"measured\"
source = \"who recorded, when, where\"
full_scale_pa = 20.0                   # pressure of the largest integer of an integer WAV file; float WAV and CSV are in Pa
channels = [0, 1, 2, 3, 4, 5, 6, 7]    # for every channel of a file, the microphone it records; -1 for none
ping = { rate_hz = 10000.0, quiet_samples = 1000 }  # samples before the loudspeaker acts
click = { rate_hz = 62500.0, quiet_samples = 1000 } # a click's trigger is at that sample

[[day]] # as many as there were
id = \"day-1\"
ambient_temperature_k = 293.15
ambient_temperature_sd_k = 0.1

[[calibration]] # clicks in the empty tube at ambient temperature give the delays of the channels, one per sampling rate
day = \"day-1\"
rate_hz = 10000.0
quiet_samples = 1000
clicks = [\"calibration/10000-0.wav\", \"calibration/10000-1.wav\"]

[[calibration]]
day = \"day-1\"
rate_hz = 62500.0
quiet_samples = 1000
clicks = [\"calibration/62500-0.wav\", \"calibration/62500-1.wav\"]
";

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failure> {
    let campaign = Campaign::parse(CAMPAIGN, Path::new("campaign.toml")).or_failed()?;
    // Never replaces anything: these files are written by hand.
    let folder = StagedFolder::new(&args.dir, "manifest.toml", false)?;
    let manifest: String = campaign.points.iter().map(point).collect();
    let files = [
        ("rig.toml", RIG.to_owned()),
        ("campaign.toml", CAMPAIGN.to_owned()),
        ("candidates.toml", CANDIDATES.to_owned()),
        ("manifest.toml", format!("{MANIFEST}{manifest}")),
    ];
    let names = files.each_ref().map(|f| f.0);
    for (name, text) in files {
        let path = folder.path().join(name);
        std::fs::write(&path, text).or_failed().map_err(|f| f.at(&path))?;
    }
    folder.commit()?;
    let dir = args.dir.display();
    ui.say(format!("{dir}: fill in rig.toml, campaign.toml and manifest.toml, put the records where manifest.toml names them"));
    ui.say(format!("then: rijke check {dir}"));
    ui.result(&json!({ "dir": args.dir, "files": names }))
}

/// The entry of an operating point, with the names that its records may have.
fn point(point: &OperatingPoint) -> String {
    let names = |kind: &str| {
        let names = (0..point.repeats).map(|k| format!("\"{}/{kind}-{k}.wav\"", point.id));
        names.collect::<Vec<_>>().join(", ")
    };
    format!(
        "\n[[point]]\nid = \"{}\"\nday = \"day-1\"\npings = [{}]\nclicks = [{}]\n",
        point.id,
        names("ping"),
        names("click")
    )
}
