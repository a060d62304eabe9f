//! `rijke lab`: raw records of the virtual laboratory.

use crate::{number, ui::Ui};
use rijke_flow::{POSITION, POWER, TubeCampaign, TubePoint, TubeRig};
use rijke_lab::{Truth, VirtualRig};
use rijke_numerics::words::counted;
use rijke_numerics::{Classify, Failed, StagedFolder, Tell};
use rijke_rig::{Problem, RecordSource, RigError};
use rijke_study::Campaign;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Simulate a measurement campaign: microphone records of pings and clicks, or of sweeps, as WAV files with a
/// manifest, in the format that `rijke process` reads.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  rijke lab --out virtual-rig --row C3,H30 --repeats 4\n  \
    rijke lab --out my-study/records --row C3 --repeats 4 --sweep 80 800\n\n\
    `rijke process` reads pings and clicks from any folder, and sweeps from a study with a stage of responses.")]
pub(crate) struct Args {
    /// Folder to write.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    laboratory: Laboratory,
    /// Record sweeps between these frequencies, Hz, in place of pings and clicks.
    #[arg(long, num_args = 2, value_names = ["LOW", "HIGH"], value_parser = number::positive)]
    sweep: Option<Vec<f64>>,
    /// Replace the folder if it exists.
    #[arg(long)]
    force: bool,
}

/// Which virtual rig, also for `rijke process --virtual-rig`.
#[derive(clap::Args)]
pub(crate) struct Laboratory {
    /// Rows of the campaign to record, such as C3 or H7,H15; may be repeated. All rows if not given.
    #[arg(long = "row", visible_alias = "rows", value_name = "ROW", value_delimiter = ',')]
    rows: Vec<String>,
    /// Records of each kind per operating point, 1 to 100 [default: the campaign's own number].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100))]
    repeats: Option<u32>,
    /// Seed of all random numbers: the same seed gives the same bytes [default: 1].
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// File of the heated tube, tube.toml [default: the rig of Juniper & Yoko 2022].
    #[arg(long, value_name = "FILE")]
    rig: Option<PathBuf>,
    /// Campaign file (TOML; it may name ramps), or campaign.csv of a study [default: Table 1 of Juniper &
    /// Yoko 2022].
    #[arg(long, value_name = "FILE")]
    campaign: Option<PathBuf>,
    /// What is true in the laboratory [default: crates/lab/data/truth.toml of the project].
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
}

impl Laboratory {
    /// Sets it up.
    pub(crate) fn open(&self) -> Result<VirtualRig, Failed> {
        let rig =
            self.rig.as_deref().map_or(Ok(TubeRig::juniper_yoko_2022()), TubeRig::read).or_bad_input()?;
        let campaign = self.campaign.as_deref().map_or(Ok(TubeCampaign::juniper_yoko_2022()), campaign)?;
        let path = self.campaign.as_deref().unwrap_or(Path::new("campaign"));
        for point in &campaign.points {
            rig.point(&point.into())
                .map_err(|(place, problem)| Failed::of_input(&RigError::invalid(path, place, problem)))?;
        }
        let truth = self.truth.as_deref().map_or(Ok(Truth::standard()), Truth::read).or_bad_input()?;
        let seed = self.seed.unwrap_or(1);
        VirtualRig::new(&rig, &campaign, &truth, &self.rows, self.repeats, seed).or_bad_input()
    }

    /// Whether any of the options was given.
    pub(crate) fn is_described(&self) -> bool {
        let files = [&self.rig, &self.campaign, &self.truth];
        !self.rows.is_empty()
            || self.repeats.is_some()
            || self.seed.is_some()
            || files.iter().any(|f| f.is_some())
    }
}

/// A campaign of the laboratory (TOML), or the table of a study (CSV), whose factors are those of the heated
/// tube.
fn campaign(path: &Path) -> Result<TubeCampaign, Failed> {
    if path.extension().is_none_or(|end| end != "csv") {
        return TubeCampaign::read(path).or_bad_input();
    }
    let campaign = Campaign::read(path).or_bad_input()?;
    if let Some(name) = [POSITION, POWER].into_iter().find(|name| campaign.factor(name).is_none()) {
        let known = campaign.factors.iter().map(|f| f.name.clone()).collect();
        let problem = Problem::NoSuchHeading { name: name.into(), known };
        return Err(Failed::of_input(&RigError::invalid(path, "factors of the heated tube", problem)));
    }
    let points = campaign.operating_points();
    let points = points.iter().map(|point| {
        TubePoint::of(point)
            .map_err(|(place, problem)| Failed::of_input(&RigError::invalid(path, place, problem)))
    });
    let points = points.collect::<Result<_, _>>()?;
    Ok(TubeCampaign { name: path.display().to_string(), points, ramps: Vec::new() })
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failed> {
    let lab = args.laboratory.open()?;
    let rate = lab.set().ping.rate_hz;
    let sweep = match args.sweep.as_deref() {
        Some(&[low, high]) if low < high && high <= 0.25 * rate => Some([low, high]),
        Some(band) => {
            return Err(Failed::bad_input(format!(
                "--sweep {band:?}: from a lower to a higher frequency, up to a quarter of the sampling rate of {rate} Hz"
            ))
            .remedy("Give two such frequencies, such as --sweep 80 800."));
        }
        None => None,
    };
    let folder = StagedFolder::new(&args.out, "manifest.toml", args.force)?;
    ui.after_killed_run(&folder);
    let records = if sweep.is_some() { lab.sweep_count() } else { lab.record_count() };
    let progress = ui.progress("recording", records as u64);
    let written = |records| progress(records as u64);
    match sweep {
        Some(band) => lab.write_sweeps(folder.path(), band, &written),
        None => lab.write(folder.path(), &written),
    }
    .or_failed()?;
    drop(progress);
    folder.commit()?;
    let points = lab.set().points.len();
    let said = [counted(records, "record"), counted(points, "operating point")];
    ui.note(format!("{}: {}", args.out.display(), said.join(" of ")));
    ui.result(&json!({ "dir": args.out, "records": records, "points": points }))
}
