//! `rijke run`: all steps from records to a page.

use crate::{
    Program,
    check::foresight::{self, Subject},
    failure::{Classify, Failure},
    rank::own,
    staging::Lock,
    ui::Ui,
};
use clap::Parser;
use rijke_engine::run::Trusted;
use rijke_rig::{Observations, PointObservations};
use std::path::{Path, PathBuf};

/// Take a folder from records to ranked models: check, process, flow, rank, report.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  rijke run my-rig\n\n\
    Writes DIR/observations, DIR/base-flow and DIR/results with its page index.html and, in\n\
    DIR/results/priors, what the priors alone would have predicted. Steps that were finished before are kept,\n\
    so an interrupted run goes on where it was. A folder with observations and no records starts from there.\n\n\
    A study folder (with study.toml, see docs/study-folder.md) is run stage by stage into DIR/results.")]
pub(crate) struct Args {
    /// Folder of records with its manifest.toml, or with observations prepared by hand in DIR/observations.
    dir: PathBuf,
    /// Files of candidates of your own, which compete with those of the project [default: DIR/candidates.toml if it exists].
    #[arg(long, value_name = "FILE", num_args = 1..)]
    candidates: Vec<PathBuf>,
    /// In a study: look for one maximum of each posterior only, from the prior's middle. Some ten times faster; another maximum is then
    /// missed without a word.
    #[arg(long)]
    one_start: bool,
    /// Take every step again, and replace what they wrote.
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failure> {
    let dir = &args.dir;
    let _lock = dir.is_dir().then(|| Lock::within(dir)).transpose()?;
    if crate::study::is_study(dir) {
        let trusted = if args.one_start { Trusted::Laplace } else { Trusted::Checked };
        return crate::study::run(dir, args.force, trusted, ui);
    }
    let mut candidates = args.candidates.clone();
    if candidates.is_empty() && dir.join("candidates.toml").is_file() {
        candidates.push(dir.join("candidates.toml"));
    }
    for file in &candidates {
        // Known now rather than after an hour.
        rijke_candidates::Catalogue::read(file)
            .or_bad_input()
            .map_err(|f| f.remedy("`rijke candidate --symbols` lists what a formula may name."))?;
    }
    let (observations, flow, results) =
        (dir.join("observations"), dir.join("base-flow"), dir.join("results"));
    // A ranking without its page was interrupted between the two.
    let ranked = results.join("numbers").is_dir();
    let unfinished = ranked && !results.join("index.html").exists();
    if results.exists() && !args.force && !unfinished {
        return Err(Failure::bad_input(format!("{}: exists already", results.display()))
            .remedy("Move it away, or take every step again with --force."));
    }
    let has_records = dir.join("manifest.toml").exists() || !observations.is_dir();
    if has_records && (args.force || !observations.is_dir()) {
        let mut check = vec!["check".to_owned(), text(dir)];
        if !candidates.is_empty() {
            check.push("--candidates".to_owned());
            check.extend(candidates.iter().map(|file| text(file)));
        }
        step(&check.iter().map(String::as_str).collect::<Vec<_>>(), false, ui)?;
        step(&["process", &text(dir)], args.force, ui)?;
    } else {
        ui.note(format!("{}: kept", observations.display()));
    }

    let read = Observations::read(&observations).or_bad_input()?;
    let instead_of_clicks = [rijke_flow::PROFILES, rijke_flow::settled::Readings::FILE];
    let instead_of_clicks = instead_of_clicks.iter().any(|file| observations.join(file).is_file());
    let hot = hot_points(&read, instead_of_clicks, ui);
    if hot && (args.force || !flow.is_dir()) {
        step(&["flow", &text(dir), "--out", &text(&flow)], args.force, ui)?;
    } else if hot {
        ui.note(format!("{}: kept", flow.display()));
    }
    let (dir, flow, results) = (text(dir), text(&flow), text(&results));
    let mut rank = vec!["rank", &*dir, "--out", &*results];
    if hot {
        rank.extend(["--flow", &*flow]);
    }
    let own_files: Vec<String> = candidates.iter().map(|file| text(file)).collect();
    if !own_files.is_empty() {
        rank.push("--candidates");
        rank.extend(own_files.iter().map(String::as_str));
    }
    if args.force || !unfinished {
        step(&rank, args.force, ui)?;
    }
    let priors = Path::new(&results).join("priors");
    if !priors.is_dir() {
        let points: Vec<_> = read.points.iter().map(|p| p.point.clone()).collect();
        let subject = Subject::observed(&read, own::candidates(&candidates, &read.rig, &points)?);
        foresight::draw(&subject, &priors, false, &ui.of_a_step())?;
    }
    step(&["report", &results], false, ui)?;
    let results = Path::new(&results);
    let model = Some(results.join("model.json")).filter(|m| m.is_file());
    ui.result(&serde_json::json!({ "observations": observations, "base_flow": hot.then_some(flow), "page": results.join("index.html"), "model": model }))
}

/// Whether there are hot points that can be trained on: with clicks, and on top of what a cold heater teaches.
fn hot_points(observations: &Observations, instead_of_clicks: bool, ui: &Ui) -> bool {
    let any = |wanted: &dyn Fn(&PointObservations) -> bool| observations.points.iter().any(wanted);
    if !any(&|p| p.point.power > 0.0) {
        return false;
    }
    let cold = |thermocouples: bool| {
        any(&|p| p.point.heater && p.point.power == 0.0 && p.point.thermocouples == thermocouples)
    };
    let missing = [
        (
            instead_of_clicks || any(&|p| p.point.power > 0.0 && p.click.is_some()),
            "clicks, readings or profiles at hot points",
        ),
        (cold(false), "points with a cold heater and no thermocouples"),
        (cold(true), "points with a cold heater and thermocouples"),
    ];
    let missing: Vec<_> = missing.iter().filter(|(there, _)| !there).map(|(_, what)| *what).collect();
    if !missing.is_empty() {
        ui.note(format!("the hot points are not used, because these are missing: {}", missing.join("; ")));
    }
    missing.is_empty()
}

/// Takes one step as if it had been called by itself.
fn step(words: &[&str], force: bool, ui: &Ui) -> Result<(), Failure> {
    let words: Vec<&str> = ["rijke"].iter().chain(words).copied().chain(force.then_some("--force")).collect();
    ui.note(words.join(" "));
    let program = Program::try_parse_from(&words).or_failed()?;
    // What a step makes is replaced only if it is there: --force without it is the same as without --force.
    program.command.run(&ui.of_a_step())
}

fn text(path: &Path) -> String {
    path.display().to_string()
}
