//! `rijke new`: the folder of a study, to fill in.

mod templates;

use crate::ui::Ui;
use rijke_numerics::{Classify, Failed, StagedFolder, write_within};
use rijke_rig::OperatingPoint;
use rijke_study::Campaign;
use serde_json::json;
use std::path::{Path, PathBuf};
use templates::{HEATED_TUBE_MANIFEST, Template};

/// Write a commented study to fill in: rig.toml, campaign.csv, candidates, study.toml, and drafts of records
/// and observations.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  rijke new my-rig --template quarter-wave\n  rijke check my-rig\n\n\
    The study passes `rijke check` as it is: no data, and what the planned points would tell. Then move draft/records or\n\
    draft/observations up into the folder, with your files or numbers in it, and `rijke run my-rig`.")]
pub(crate) struct Args {
    /// Folder to write.
    dir: PathBuf,
    /// The kind of rig that is nearest to yours.
    #[arg(long, value_enum)]
    template: Template,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failed> {
    // Never replaces anything: these files are written by hand.
    if args.dir.join("study.toml").is_file() {
        let remedy = "Give another name; what stands there was written by hand.";
        return Err(Failed::bad_input("holds a study already").at(&args.dir).remedy(remedy));
    }
    let folder = StagedFolder::new(&args.dir, "study.toml", false)?;
    let mut names: Vec<&str> = Vec::new();
    for (name, text) in args.template.files() {
        write_within(folder.path(), name, text)?;
        names.push(name);
    }
    if args.template == Template::HeatedTube {
        let name = "draft/records/manifest.toml";
        write_within(folder.path(), name, manifest(&folder.path().join("campaign.csv"))?)?;
        names.push(name);
    }
    folder.commit()?;
    let dir = args.dir.display();
    ui.say(format!("{dir}: fill in rig.toml, campaign.csv, candidates/*.toml and study.toml"));
    ui.say(format!(
        "then: rijke check {dir}; and with draft/records or draft/observations filled in and moved up: rijke run {dir}"
    ));
    ui.result(&json!({ "dir": args.dir, "files": names }))
}

/// The manifest of the heated tube, with the names that the records of its campaign may have.
fn manifest(campaign: &Path) -> Result<String, Failed> {
    let campaign = Campaign::read(campaign).or_failed()?;
    let points: String = campaign.operating_points().iter().map(point).collect();
    Ok(format!("{HEATED_TUBE_MANIFEST}{points}"))
}

/// The entry of an operating point.
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
