//! `rijke check`: reads everything that the other steps will read, before any work, and says what the measurements can tell.

pub(crate) mod foresight;
mod identify;
mod prior;
pub(crate) mod stages;

use crate::{
    failure::{Classify, Failure},
    rank::own,
    ui::Ui,
};
use foresight::Subject;
use rayon::prelude::*;
use rijke_rig::{
    Campaign, DataKind, Observations, OperatingPoint, Record, RecordFolder, RecordSet, RecordSource, Rig,
    RigError,
};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Check a folder of records, and whether the measurements can identify the models: manifest, rig, campaign, candidates, and
/// every sample of every file.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  rijke check virtual-rig\n  rijke check my-rig --plan --plots my-rig/priors\n\n\
    Prints what the folder holds and which records are clipped, or every file that is wrong. Then, for every model that `rijke rank`\n\
    would train, which parameters the measurements would leave as uncertain as the priors: to first order at the centre of the\n\
    priors, on top of the models that the paper chose for the earlier stages. Hot points have the steady flow at handbook values."
)]
pub(crate) struct Args {
    /// Folder that holds manifest.toml, or observations prepared by hand in DIR/observations.
    dir: PathBuf,
    /// Before anything is recorded: read only rig.toml, campaign.toml and candidates of DIR.
    #[arg(long)]
    plan: bool,
    /// Files of candidates of your own [default: DIR/candidates.toml if it exists].
    #[arg(long, value_name = "FILE", num_args = 1..)]
    candidates: Vec<PathBuf>,
    /// Noise of one operating point, model error included: growth rate (1/s), angular frequency (rad/s), relative pressure.
    #[arg(long, value_name = "SD", num_args = 3, default_values_t = foresight::NOISE_SD, value_parser = crate::number::positive)]
    sd: Vec<f64>,
    /// Draw growth rate and frequency as the priors of each model allow them, with what was observed, into this folder.
    #[arg(long, value_name = "OUT")]
    plots: Option<PathBuf>,
    /// Replace OUT if it exists.
    #[arg(long)]
    force: bool,
}

/// At most this many wrong files are listed.
const MOST: usize = 20;
/// Ambient temperature of a campaign that is only planned, K.
const PLANNED_AMBIENT: f64 = 293.15;

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failure> {
    let dir = &args.dir;
    let [growth, frequency, pressure] = args.sd[..] else { return Err(wrong_sd(&args.sd)) };
    let sd = [growth, frequency, pressure];
    if !sd.iter().all(|sd| *sd > 0.0 && sd.is_finite()) {
        return Err(wrong_sd(&args.sd));
    }
    let observations = dir.join("observations");
    let observed = (observations.is_dir() && !args.plan)
        .then(|| Observations::read(&observations))
        .transpose()
        .or_bad_input()?;
    let (rig, points, kind, mut answer): (_, Vec<(OperatingPoint, f64)>, _, _) = if args.plan {
        let rig = Rig::read(&dir.join("rig.toml")).or_bad_input()?;
        let campaign = Campaign::read(&dir.join("campaign.toml")).or_bad_input()?;
        ui.say(format!("{}: planned, {} operating points", rig.name, campaign.points.len()));
        let answer = json!({ "rig": rig.name, "points": campaign.points.len() });
        (rig, campaign.points.into_iter().map(|p| (p, PLANNED_AMBIENT)).collect(), None, answer)
    } else if let (Some(read), false) = (&observed, dir.join("manifest.toml").exists()) {
        ui.say(format!(
            "{}: observations of {} operating points, {}",
            read.rig.name,
            read.points.len(),
            read.source
        ));
        let points = read.points.iter().map(|p| (p.point.clone(), p.ambient.ambient_temperature)).collect();
        (
            read.rig.clone(),
            points,
            Some(read.kind),
            json!({ "rig": read.rig.name, "points": read.points.len() }),
        )
    } else {
        let (set, answer) = records_of(dir, ui)?;
        let ambient = |day: usize| set.days[day].ambient_temperature;
        let points = set.points.iter().map(|p| (p.point.clone(), ambient(p.day))).collect();
        (set.rig, points, Some(set.kind), answer)
    };
    let mut files = args.candidates.clone();
    if files.is_empty() && dir.join("candidates.toml").is_file() {
        files.push(dir.join("candidates.toml"));
    }
    let list: Vec<_> = points.iter().map(|(p, _)| p.clone()).collect();
    let own = own::candidates(&files, &rig, &list)?;
    let measured = observed.as_ref().map(foresight::measured).unwrap_or_default();
    let subject = Subject { rig, points, kind, own, measured };
    answer["models"] = foresight::say(&subject, sd, ui)?;
    if let Some(out) = &args.plots {
        answer["plots"] = foresight::draw(&subject, out, args.force, ui)?;
    }
    ui.result(&answer)
}

fn wrong_sd(sd: &[f64]) -> Failure {
    Failure::bad_input(format!("--sd {sd:?}: standard deviations must be positive and finite"))
        .remedy("Give three numbers, such as --sd 0.1 1 0.001; see --help.")
}

/// Reads every record of a folder, and says what it holds.
fn records_of(dir: &Path, ui: &Ui) -> Result<(RecordSet, serde_json::Value), Failure> {
    let folder = RecordFolder::open(dir).or_bad_input()?;
    let set = folder.set();
    let records = records(set);
    let bar = ui.progress("reading", records.len() as u64);
    let read: Vec<Result<usize, RigError>> = records
        .par_iter()
        .map(|record| {
            let samples = record.read(&folder);
            bar.advance(1);
            samples.map(|r| clipped(&r))
        })
        .collect();
    drop(bar);

    let wrong: Vec<_> = read.iter().filter_map(|r| r.as_ref().err()).collect();
    if !wrong.is_empty() {
        let shown: Vec<_> = wrong.iter().take(MOST).map(ToString::to_string).collect();
        let rest = wrong.len().saturating_sub(MOST);
        let rest = if rest > 0 { format!("\nand {rest} more") } else { String::new() };
        let text = format!("{} of {} files are wrong\n{}{rest}", wrong.len(), read.len(), shown.join("\n"));
        return Err(Failure::bad_input(text)
            .at(dir)
            .remedy("Mend each file as its line says, or take it out of the manifest; then check again."));
    }
    describe(set, ui);
    for (record, clipped) in records.iter().zip(read.iter().flatten()).filter(|(_, c)| **c > 0) {
        ui.say(format!("clipped: {} ({clipped} samples); `rijke process` will reject it", record.name(set)));
    }
    let clipped = records.iter().zip(read.iter().flatten()).filter(|(_, c)| **c > 0);
    let clipped: Vec<_> = clipped.map(|(r, c)| json!({ "file": r.name(set), "samples": c })).collect();
    let answer = json!({
        "rig": set.rig.name, "kind": set.kind, "source": set.source, "points": set.points.len(), "days": set.days.len(),
        "pings": set.points.iter().map(|p| p.pings.len()).sum::<usize>(),
        "clicks": set.points.iter().map(|p| p.clicks.len()).sum::<usize>(), "clipped": clipped,
    });
    Ok((set.clone(), answer))
}

/// One file of a set.
enum Item {
    Ping(usize, usize),
    Click(usize, usize),
    Calibration(usize, usize),
}

impl Item {
    fn read(&self, folder: &RecordFolder) -> Result<Record, RigError> {
        match *self {
            Self::Ping(point, repeat) => folder.ping(point, repeat),
            Self::Click(point, repeat) => folder.click(point, repeat),
            Self::Calibration(which, repeat) => folder.calibration(which, repeat),
        }
    }

    fn name<'a>(&self, set: &'a RecordSet) -> &'a str {
        match *self {
            Self::Ping(point, repeat) => &set.points[point].pings[repeat],
            Self::Click(point, repeat) => &set.points[point].clicks[repeat],
            Self::Calibration(which, repeat) => &set.calibrations[which].clicks[repeat],
        }
    }
}

fn records(set: &RecordSet) -> Vec<Item> {
    let points = set.points.iter().enumerate().flat_map(|(i, point)| {
        let pings = (0..point.pings.len()).map(move |r| Item::Ping(i, r));
        pings.chain((0..point.clicks.len()).map(move |r| Item::Click(i, r)))
    });
    let calibrations = set.calibrations.iter().enumerate();
    points
        .chain(calibrations.flat_map(|(i, c)| (0..c.clicks.len()).map(move |r| Item::Calibration(i, r))))
        .collect()
}

fn clipped(record: &Record) -> usize {
    let limit = record.full_scale * (1.0 - 1e-6);
    record.channels.iter().flatten().filter(|p| p.abs() >= limit).count()
}

fn describe(set: &RecordSet, ui: &Ui) {
    let kind = match set.kind {
        DataKind::Measured => "measured",
        DataKind::Virtual => "virtual",
    };
    ui.say(format!("{}: {kind} data, {}", set.rig.name, set.source));
    let pings: usize = set.points.iter().map(|p| p.pings.len()).sum();
    let clicks: usize = set.points.iter().map(|p| p.clicks.len()).sum();
    ui.say(format!(
        "{} operating points on {} days: {pings} pings at {} Hz, {clicks} clicks at {} Hz",
        set.points.len(),
        set.days.len(),
        set.ping.rate_hz,
        set.click.rate_hz
    ));
    for calibration in &set.calibrations {
        ui.say(format!(
            "{} calibration clicks at {} Hz on {}",
            calibration.clicks.len(),
            calibration.stretch.rate_hz,
            set.days[calibration.day].id
        ));
    }
}
