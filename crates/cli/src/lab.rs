//! `rijke lab`: raw records of the virtual laboratory.

use crate::{
    failure::{Classify, Failure},
    staging::StagedFolder,
    ui::Ui,
};
use rijke_lab::{Truth, VirtualRig};
use rijke_rig::{Campaign, RecordSource, Rig};
use std::path::PathBuf;

/// Record a campaign in the virtual laboratory: raw microphone records of pings and clicks, as WAV files with a
/// manifest, exactly as `rijke process` reads them from a real rig.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  rijke lab --out virtual-rig --row C3 --repeats 4")]
pub(crate) struct Args {
    /// Folder to write.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Row of the campaign to record, such as C3; may be repeated. All rows if not given.
    #[arg(long, value_name = "ROW")]
    row: Vec<String>,
    /// Records of each kind per operating point, 1 to 100 [default: the campaign's own number].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100))]
    repeats: Option<u32>,
    /// Seed of all random numbers: the same seed gives the same bytes.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Rig file [default: the rig of Juniper & Yoko 2022].
    #[arg(long, value_name = "FILE")]
    rig: Option<PathBuf>,
    /// Campaign file [default: Table 1 of Juniper & Yoko 2022].
    #[arg(long, value_name = "FILE")]
    campaign: Option<PathBuf>,
    /// What is true in the laboratory [default: fixtures/lab/truth.toml of the project].
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    /// Replace the folder if it exists.
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failure> {
    let rig = args.rig.as_deref().map_or(Ok(Rig::juniper_yoko_2022()), Rig::read).or_bad_input()?;
    let campaign =
        args.campaign.as_deref().map_or(Ok(Campaign::juniper_yoko_2022()), Campaign::read).or_bad_input()?;
    let truth = args.truth.as_deref().map_or(Ok(Truth::standard()), Truth::read).or_bad_input()?;
    let lab = VirtualRig::new(&rig, &campaign, &truth, &args.row, args.repeats, args.seed).or_bad_input()?;
    let folder = StagedFolder::new(&args.out, "manifest.toml", args.force)?;
    let progress = ui.progress("recording", lab.record_count() as u64);
    lab.write(folder.path(), &|records| progress.advance(records as u64)).or_failed()?;
    drop(progress);
    folder.commit()?;
    let points = lab.set().points.len();
    ui.note(format!("{}: {} records of {points} operating points", args.out.display(), lab.record_count()));
    Ok(())
}
