//! `rijke run`: a study from its files to its page.

use crate::{flow, process, rank, trust::Trust, ui::Ui};
use rijke_engine::folder::{FILES_NAMED, is_measured, open_study};
use rijke_intake::flow_is_due;
use rijke_numerics::words::few;
use rijke_numerics::{Failed, Lock};
use rijke_report::draw_study;
use rijke_study::{Study, changed_records, changed_study};
use std::path::{Path, PathBuf};

/// Take a study from its files to ranked models and a page: process records, infer the base flow, rank,
/// report.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  rijke run examples/quarter-wave\n\n\
    DIR holds rig.toml, campaign.csv or campaign.toml, candidates/*.toml and study.toml, and observations/ or records/. Writes\n\
    DIR/results with its page index.html. An interrupted run goes on where it was; one that has its page is refused\n\
    without --force.")]
pub(crate) struct Args {
    /// Folder of the study.
    dir: PathBuf,
    #[command(flatten)]
    trust: Trust,
    /// Take every step again, and replace what earlier runs wrote.
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failed> {
    let dir = &args.dir;
    let study = open_study(dir)?;
    if study.plan.stages.is_empty() {
        processed(dir, args.force, ui)?;
        return rank::run(&rank::Args::of(dir, args.trust, args.force), ui);
    }
    let results = dir.join("results");
    // One run at a time; each step takes its own folder besides.
    let _lock = Lock::within(dir)?;
    let finished = results.join("index.html").is_file();
    if finished && !args.force {
        let changed = changed_study(dir);
        let of = match changed.is_empty() {
            true => String::new(),
            false => format!(", and {} changed since", few(&changed, FILES_NAMED)),
        };
        return Err(Failed::bad_input(format!("{}: exists already{of}", results.display()))
            .remedy("Move it away, or take every step again with --force."));
    }
    steps(&study, args.trust, args.force, ui).map(|_| ())
}

/// All steps again, whatever was finished before.
pub(crate) fn from_the_start(dir: &Path, trust: Trust, ui: &Ui) -> Result<PathBuf, Failed> {
    let study = open_study(dir)?;
    let _lock = Lock::within(dir)?;
    steps(&study, trust, true, ui)
}

fn steps(study: &Study, trust: Trust, force: bool, ui: &Ui) -> Result<PathBuf, Failed> {
    let dir = &study.folder;
    processed(dir, force, ui)?;
    let base = dir.join("base");
    // Inferred states can also be brought along.
    if flow_is_due(study) && (force || !base.is_dir()) {
        ui.note(format!("flow {}", dir.display()));
        flow::of_study(dir, &base, force, &ui.of_a_step())?;
    }
    let results = dir.join("results");
    let ranked = results.join("numbers/claims.json").is_file() && changed_study(dir).is_empty();
    if force || !ranked {
        rank::run(&rank::Args::of(dir, trust, results.is_dir()), ui)?;
    }
    let page = draw_study(dir)?;
    ui.note(format!("page: {}", page.display()));
    Ok(page)
}

/// Processes the records of a study, if there are any; what was processed before is kept without `force`.
fn processed(dir: &Path, force: bool, ui: &Ui) -> Result<(), Failed> {
    let (records, observations) = (dir.join("records"), dir.join("observations"));
    let changed = changed_records(dir);
    if !force && !changed.is_empty() {
        let (shown, changed) = (observations.display(), few(&changed, FILES_NAMED));
        return Err(Failed::bad_input(format!("{shown}: of other records: {changed} changed since"))
            .remedy("Move it away, or take every step again with --force."));
    }
    if !records.is_dir() {
        return Ok(());
    }
    if !force && is_measured(&observations) {
        let [by_hand, processed] = ["modes.csv", "pings.csv"].map(|name| observations.join(name).exists());
        if by_hand && !processed && records.join("manifest.toml").exists() {
            ui.note(
                "observations/ has modes.csv, so the records are not processed; `rijke process` with --force adds what they hold",
            );
        }
        return Ok(());
    }
    ui.note(format!("process {}", records.display()));
    process::records(&records, &observations, force, &ui.of_a_step())
}
