//! `rijke flow`: from click arrival times to the base flow.

use crate::{
    failure::{Classify, Failure},
    staging::StagedFolder,
    ui::Ui,
};
use rayon::prelude::*;
use rijke_flow::assimilate::{Method, Records, RunReport, Twin, TwinOptions, Warning, assimilate, staircase};
use rijke_flow::{Closures, FlowError, Pipe};
use rijke_numerics::Streams;
use rijke_rig::{DataKind, Rig};
use serde::Serialize;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Infer velocity, temperature and sound speed along the tube from clicks (or thermocouples) over time.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  rijke flow --twin --out clicks\n  rijke flow clicks --out base-flow\n\n\
    Reads DIR/flow.toml and the CSV files of samples that it names. Writes OUT/flow.json (everything, with the\n\
    covariance that acoustics carries along), OUT/unknowns.csv and OUT/velocity.csv.")]
pub(crate) struct Args {
    /// Folder of samples over time.
    #[arg(required_unless_present = "twin")]
    dir: Option<PathBuf>,
    /// Folder to write.
    #[arg(long, value_name = "OUT")]
    out: PathBuf,
    /// How to assimilate. Batch is the one whose error bars were tested; paper is the filter of Juniper & Yoko (2022),
    /// whose error bars are about ten times too small.
    #[arg(long, value_enum, default_value_t = Choice::Batch)]
    method: Choice,
    /// TOML file of closures [default: those of the model].
    #[arg(long, value_name = "FILE")]
    closures: Option<PathBuf>,
    /// Write a virtual record to try the command on, instead of reading one.
    #[arg(long, conflicts_with = "dir")]
    twin: bool,
    /// Heater positions of the virtual record, m.
    #[arg(long, value_delimiter = ',', default_values_t = [0.25, 0.75], requires = "twin")]
    heaters: Vec<f64>,
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Replace OUT if it exists.
    #[arg(long)]
    force: bool,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Choice {
    Batch,
    Smoother,
    Paper,
    SquareRoot,
}

/// OUT/flow.json.
#[derive(Serialize)]
struct Document {
    kind: DataKind,
    rig: String,
    seed: u64,
    runs: Vec<RunReport>,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failure> {
    let closures = args.closures.as_deref().map_or(Ok(Closures::default()), read_closures)?;
    match &args.dir {
        Some(dir) if !args.twin => infer(args, dir, &closures, ui),
        _ => twin(args, &closures, ui),
    }
}

fn read_closures(path: &Path) -> Result<Closures, Failure> {
    let text = std::fs::read_to_string(path).or_bad_input().map_err(|f| f.at(path))?;
    toml::from_str(&text).or_bad_input().map_err(|f| f.at(path))
}

fn infer(args: &Args, dir: &Path, closures: &Closures, ui: &Ui) -> Result<(), Failure> {
    let remedy = "`rijke flow --twin --out DIR` writes a folder of the right form.";
    let records = Records::read(dir).or_bad_input().map_err(|f| f.remedy(remedy))?;
    let staged = StagedFolder::new(&args.out, "flow.json", args.force)?;
    let method = match args.method {
        Choice::Batch => Method::Batch,
        Choice::Smoother => Method::Smoother,
        Choice::Paper => Method::Paper,
        Choice::SquareRoot => Method::SquareRoot,
    };
    let progress = ui.progress("heater positions", records.runs.len() as u64);
    let runs: Result<Vec<RunReport>, FlowError> = records
        .runs
        .par_iter()
        .map(|(heater, record)| {
            let streams = Streams::new(args.seed);
            let run = assimilate(&records.rig, closures, *heater, record, method, &streams);
            progress.advance(1);
            run
        })
        .collect();
    let runs = runs.or_failed()?;
    drop(progress);
    let document = Document { kind: records.kind, rig: records.rig.name.clone(), seed: args.seed, runs };
    let write = |name: &str, text: String| {
        let path = staged.path().join(name);
        std::fs::write(&path, text).or_failed().map_err(|f| f.at(&path))
    };
    write("flow.json", serde_json::to_string_pretty(&document).or_failed()? + "\n")?;
    write("unknowns.csv", unknowns_table(&document.runs))?;
    write("velocity.csv", velocity_table(&document.runs))?;
    staged.commit()?;
    for run in &document.runs {
        summary(run, ui);
    }
    Ok(())
}

fn unknowns_table(runs: &[RunReport]) -> String {
    let mut text = String::from("heater_m,unknown,unit,value,low_2sd,high_2sd,posterior_over_prior_sd\n");
    for run in runs {
        for u in &run.unknowns {
            let _ = writeln!(
                text,
                "{},{},{},{},{},{},{}",
                run.heater_m, u.name, u.unit, u.value, u.low, u.high, u.shrinkage
            );
        }
    }
    text
}

fn velocity_table(runs: &[RunReport]) -> String {
    let mut text = String::from(
        "heater_m,power_w,ambient_k,heater_velocity_m_per_s,sd_m_per_s,highest_sound_speed_m_per_s,sd_m_per_s\n",
    );
    for run in runs {
        for p in &run.powers {
            let hottest = p.profile.iter().max_by(|a, b| a.sound_speed.total_cmp(&b.sound_speed));
            let (c, sd) = hottest.map_or((f64::NAN, f64::NAN), |h| (h.sound_speed, h.sound_speed_sd));
            let (u, u_sd) = (p.heater_velocity, p.heater_velocity_sd);
            let _ = writeln!(text, "{},{},{},{u},{u_sd},{c},{sd}", run.heater_m, p.power_w, p.ambient_k);
        }
    }
    text
}

fn summary(run: &RunReport, ui: &Ui) {
    ui.say(format!("heater at {} m", run.heater_m));
    for u in &run.unknowns {
        let note = if u.shrinkage > 0.7 { "   not identified: the prior" } else { "" };
        ui.say(format!("  {:<17} {:>9.4} [{:.4}, {:.4}] {}{note}", u.name, u.value, u.low, u.high, u.unit));
    }
    if let Some(p) = run.powers.last() {
        ui.say(format!(
            "  at {} W: {:.4} +- {:.4} m/s at the heater",
            p.power_w, p.heater_velocity, p.heater_velocity_sd
        ));
    }
    if let Some(chi) = run.innovation_chi_squared {
        ui.say(format!(
            "  chi-squared of the innovations {chi:.3}: no proof that the parameters are right; compare with --method batch"
        ));
    }
    for warning in &run.warnings {
        ui.say(format!("  do not trust this result: {}", words(warning)));
    }
}

fn words(warning: &Warning) -> String {
    match warning {
        Warning::PoorFit { chi_squared } => {
            format!("chi-squared per datum is {chi_squared:.2}, so the model misses more than the noise")
        }
        Warning::Pattern { sensor, correlation } => {
            format!(
                "the residuals of sensor {sensor} follow a pattern in time (correlation {correlation:.2})"
            )
        }
        Warning::AtBound { name } => format!("{name} is held by the bound of its prior"),
        Warning::NotConverged => "the search for the most probable unknowns gave up".into(),
    }
}

/// A virtual record: the model itself at the centre of its priors, with noise, for the paper's staircase of powers.
fn twin(args: &Args, closures: &Closures, ui: &Ui) -> Result<(), Failure> {
    let rig = Rig::juniper_yoko_2022();
    let powers = staircase(&[0.0, 7.0, 15.0, 30.0, 50.0, 80.0, 130.0, 180.0], 250);
    let options = TwinOptions { powers, ..TwinOptions::default() };
    let record = |heater: &f64| {
        let pipe = Pipe::new(&rig, closures, *heater, 1)?;
        let streams = Streams::new(args.seed);
        let scores = vec![0.0; rijke_flow::UNKNOWNS + pipe.microphones().count()];
        Ok((*heater, Twin::new(&pipe, &options, &streams, Some(&scores))?.record))
    };
    let runs: Result<Vec<_>, FlowError> = args.heaters.par_iter().map(record).collect();
    let records = Records { kind: DataKind::Virtual, rig: rig.clone(), runs: runs.or_bad_input()? };
    let staged = StagedFolder::new(&args.out, "flow.toml", args.force)?;
    records.write(staged.path()).or_failed()?;
    staged.commit()?;
    ui.note(format!("wrote a virtual record of {} heater positions", args.heaters.len()));
    Ok(())
}
