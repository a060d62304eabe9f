//! `rijke flow`: from click arrival times to the base flow.

mod foreseen;
mod plot;
mod states;

use crate::{
    csv_table::csv_table,
    failure::{Classify, Failure},
    number,
    ui::Ui,
};
pub(crate) use foreseen::foresee;
use rijke_flow::assimilate::{self, AssimilationMethod, NamedStates, Records, RunReport};
use rijke_flow::settled;
use rijke_flow::shown::{FlowDocument, settles, together, unknowns_table, velocity_table, words};
use rijke_flow::{
    BaseStates, Closures, FlowError, HeatedTube, PROFILES, TubeObservations, TubeRig, read_profiles,
};
use rijke_numerics::StagedFolder;
use rijke_rig::DataKind;
use rijke_study::{Study, plan::Base};
use std::path::{Path, PathBuf};

/// Infer velocity, temperature and sound speed along the tube from clicks (or thermometers) over time.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  rijke flow virtual-rig --out base-flow\n  rijke flow --twin --out clicks && rijke flow clicks --out base-flow\n\n\
    Reads DIR/observations (or DIR itself) as `rijke process` writes them: the mean clicks of settled operating points.\n\
    tube.toml beside them describes the heated tube.\n\
    Three files may lie beside them. readings.csv has thermometers or speeds of sound along the tube; they count with the clicks,\n\
    or alone. ramps.csv says which points were measured while the power changed, and when; their base flow is that of the moment.\n\
    profiles.csv has temperatures or sound speeds along the tube; then the base flow is that profile, and nothing is inferred.\n\
    Instead of all this, DIR/flow.toml names CSV files of samples: a record over time, warm-up included.\n\
    Writes OUT/base-states.json (a base state per operating point with its errors, for acoustics), OUT/flow.json\n\
    (parameters, velocities and profiles with sd, for figures), OUT/unknowns.csv and OUT/velocity.csv."
)]
pub(crate) struct Args {
    /// Folder of observations, or of samples over time.
    #[arg(required_unless_present = "twin")]
    dir: Option<PathBuf>,
    /// Folder to write.
    #[arg(long, value_name = "OUT")]
    out: PathBuf,
    /// How to assimilate samples over time. `batch` has the best error bars. `paper` is the filter of Juniper
    /// & Yoko (2022); its error bars are too small by a factor of twenty or more.
    #[arg(long, value_enum, default_value_t = Choice::Batch)]
    method: Choice,
    /// Fit each place of the heat source by itself, as the paper does, instead of all together as one rig.
    #[arg(long)]
    separate: bool,
    /// Draw Fig. 2, and for a filter its parameters, spread and innovations against time beside the batch
    /// fit: plots/index.html in OUT.
    #[arg(long)]
    plot: bool,
    /// TOML file of closures [default: those of the model].
    #[arg(long, value_name = "FILE")]
    closures: Option<PathBuf>,
    /// Write a virtual record to try the command on, instead of reading one.
    #[arg(long, conflicts_with = "dir")]
    twin: bool,
    /// Places of the heat source in the virtual record, m.
    #[arg(long, value_delimiter = ',', default_values_t = [0.25, 0.75], requires = "twin", value_parser = number::positive)]
    places: Vec<f64>,
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

/// Whether a study wants states that are inferred, and has the observations of which they can be.
pub(crate) fn is_due(study: &Study) -> bool {
    let observations = study.folder.join("observations");
    matches!(study.plan.base, Base::States(_))
        && ["pings.csv", HeatedTube::FILE].iter().all(|file| observations.join(file).exists())
}

/// Infers the base flow of a study with the usual options; when its ramps are settled, in words.
pub(crate) fn of_study(dir: &Path, out: &Path, force: bool, ui: &Ui) -> Result<Vec<String>, Failure> {
    let words = ["flow".into(), dir.as_os_str().to_owned(), "--out".into(), out.as_os_str().to_owned()];
    let force = force.then(|| "--force".into());
    let matches = <Args as clap::Args>::augment_args(clap::Command::new("flow"))
        .get_matches_from(words.into_iter().chain(force));
    let args = <Args as clap::FromArgMatches>::from_arg_matches(&matches).or_failed()?;
    infer(&args, dir, &Closures::default(), ui)
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failure> {
    let closures = args.closures.as_deref().map_or(Ok(Closures::default()), read_closures)?;
    match &args.dir {
        Some(dir) if !args.twin => infer(args, dir, &closures, ui).map(|_| ()),
        _ => twin(args, &closures, ui),
    }
}

fn read_closures(path: &Path) -> Result<Closures, Failure> {
    let text = rijke_numerics::read_text(path).or_bad_input().map_err(|f| f.at(path))?;
    toml::from_str(&text).or_bad_input().map_err(|f| f.at(path))
}

/// Infers and writes; when the ramps are settled, in words.
fn infer(args: &Args, dir: &Path, closures: &Closures, ui: &Ui) -> Result<Vec<String>, Failure> {
    let below = dir.join("observations");
    let settled = if below.is_dir() { Some(below.as_path()) } else { Some(dir) };
    let settled = settled.filter(|folder| folder.join("observations.toml").is_file());
    let (document, states, beside) = match settled {
        Some(folder) if !dir.join("flow.toml").is_file() => {
            let (document, states) = from_observations(args, folder, closures, ui)?;
            (document, states, Vec::new())
        }
        _ => over_time(args, dir, closures, ui)?,
    };
    let staged = ui.started(StagedFolder::new(&args.out, "flow.json", args.force)?);
    let write = |name: &str, text: String| {
        let path = staged.path().join(name);
        std::fs::write(&path, text).or_failed().map_err(|f| f.at(&path))
    };
    states.write(&staged.path().join(BaseStates::FILE)).or_failed()?;
    if let Some(observations) = settled.and_then(|folder| TubeObservations::read(folder).ok()) {
        let file = self::states::states(&states, &observations);
        write("states.json", serde_json::to_string(&file).or_failed()? + "\n")?;
    }
    write("flow.json", serde_json::to_string_pretty(&document).or_failed()? + "\n")?;
    write("unknowns.csv", csv_table(unknowns_table(&document.runs))?)?;
    write("velocity.csv", csv_table(velocity_table(&document.runs))?)?;
    if args.plot {
        plot::write(&document, &beside, staged.path())?;
    }
    staged.commit()?;
    let of_runs = document.runs.iter().flat_map(words);
    of_runs.chain(together(&document.runs)).for_each(|said| ui.say(said));
    let settling: Vec<String> = document.runs.iter().flat_map(|run| &run.settling).map(settles).collect();
    settling.iter().for_each(|said| ui.say(said));
    ui.result(&document)?;
    Ok(settling)
}

/// What both kinds of input give.
type Inferred = (FlowDocument, BaseStates);

/// From the mean clicks of settled operating points.
fn from_observations(args: &Args, folder: &Path, closures: &Closures, ui: &Ui) -> Result<Inferred, Failure> {
    let observations = TubeObservations::read(folder).or_bad_input()?;
    if folder.join(PROFILES).is_file() {
        let states = read_profiles(folder, &observations).or_bad_input()?;
        let document = FlowDocument {
            kind: states.kind,
            rig: observations.rig.name.clone(),
            seed: args.seed,
            runs: Vec::new(),
        };
        ui.say(format!("the base flow of {} operating points is that of {PROFILES}", states.points.len()));
        return Ok((document, states));
    }
    let (file, readings) = readings(folder, &observations)?;
    let runs = settled::heated(&observations, &readings, closures);
    let runs = runs.or_bad_input().map_err(|f| f.at(folder))?;
    if runs.is_empty() {
        let message = "no heated operating point with clicks or readings, so there is no flow to infer";
        let remedy = "Process the clicks of a row with power (say, H30), write temperatures or speeds of sound into readings.csv beside \
            the observations, or give a record over time with flow.toml.";
        return Err(Failure::bad_input(message).at(folder).remedy(remedy));
    }
    let progress = ui.progress("places of the heat source", runs.len() as u64);
    let found = settled::infer(&runs, args.separate, &|places| progress.advance(places));
    drop(progress);
    let (reports, states) = found.map_err(|error| match error {
        FlowError::FarOff { file: name, .. } => {
            let place = if name == settled::Readings::FILE { file.clone() } else { folder.join(name) };
            Failure::bad_input(error).at(&place).remedy(
                "Compare the readings and their units with tube.toml (gas, length, places of microphones) and with the ambient temperatures of points.csv.",
            )
        }
        _ => blame(error).at(folder),
    })?;
    Ok(gather(args, observations.kind, &observations.rig, observations.source, reports, states))
}

/// What stands in `readings.csv` among the observations or beside the study; nothing without the file.
fn readings(folder: &Path, observations: &TubeObservations) -> Result<(PathBuf, settled::Readings), Failure> {
    let beside = folder.parent().filter(|p| p.join("study.toml").exists());
    let mut files = [Some(folder), beside].into_iter().flatten().map(|f| f.join(settled::Readings::FILE));
    let file = files.find(|f| f.exists()).unwrap_or_else(|| folder.join(settled::Readings::FILE));
    let known = |id: &str| observations.points.iter().any(|p| p.point.id == id);
    let readings = match file.exists() {
        true => settled::Readings::read(&file, &known).or_bad_input()?,
        false => settled::Readings::default(),
    };
    Ok((file, readings))
}

/// Samples, of all runs, from which on a filter or the smoother takes long enough to say so.
const MANY_SAMPLES: usize = 1000;

/// From samples over time. A filter that is drawn has the batch fits of the same runs beside it.
fn over_time(
    args: &Args,
    dir: &Path,
    closures: &Closures,
    ui: &Ui,
) -> Result<(FlowDocument, BaseStates, Vec<RunReport>), Failure> {
    let records = Records::read(dir).map_err(|error| {
        let remedy = match error {
            FlowError::InLine { .. } | FlowError::InRun { .. } => "Correct the file. Samples lie at equal intervals, so none can be left out.",
            _ => "`rijke process` makes observations of records; `rijke flow --twin --out DIR` writes a record over time.",
        };
        Failure::bad_input(error).remedy(remedy)
    })?;
    let (method, filters) = match args.method {
        Choice::Batch => (AssimilationMethod::Batch, false),
        Choice::Smoother => (AssimilationMethod::Smoother, false),
        Choice::Paper => (AssimilationMethod::Paper, true),
        Choice::SquareRoot => (AssimilationMethod::SquareRoot, true),
    };
    let samples: usize = records.runs.iter().map(|(_, run)| run.samples.len()).sum();
    if !matches!(method, AssimilationMethod::Batch) && samples > MANY_SAMPLES {
        ui.note(format!(
            "{samples} samples: this method takes the whole ensemble through each, which takes minutes; --method batch needs seconds"
        ));
    }
    let progress = ui.progress("places of the heat source", records.runs.len() as u64);
    let done = || progress.advance(1);
    let found = assimilate::infer(&records, closures, method, args.seed, args.plot && filters, &done);
    drop(progress);
    let assimilate::OverTime { runs, states, batch } = found.map_err(|e| blame(e).at(dir))?;
    let source = dir.display().to_string();
    let (document, states) = gather(args, records.kind, &records.rig, source, runs, states);
    Ok((document, states, batch))
}

/// Readings under which no flow exists are the user's to mend; a search that gives up on sound ones is not.
fn blame(error: FlowError) -> Failure {
    use FlowError::{Ensemble, NoFlow, NotSteady, Power, Range};
    match error {
        NoFlow { .. } | NotSteady { .. } | Power { .. } | Range { .. } | Ensemble(_) => {
            Failure::bad_input(error)
                .remedy("Compare powers, ambient temperatures and readings of the samples with the rig; give samples at shorter intervals if \
                    theirs are longer than a few minutes.")
        }
        _ => Failure::failed(error)
            .remedy("Compare the readings with the rig; --method smoother needs no derivatives."),
    }
}

fn gather(
    args: &Args,
    kind: DataKind,
    rig: &TubeRig,
    source: String,
    runs: Vec<RunReport>,
    states: NamedStates,
) -> Inferred {
    let points = states.into_iter().collect();
    let document = FlowDocument { kind, rig: rig.name.clone(), seed: args.seed, runs };
    (document, BaseStates { kind, source, points })
}

/// Writes a virtual record.
fn twin(args: &Args, closures: &Closures, ui: &Ui) -> Result<(), Failure> {
    let records = assimilate::twins(closures, &args.places, args.seed).or_bad_input()?;
    let staged = StagedFolder::new(&args.out, "flow.toml", args.force)?;
    records.write(staged.path()).or_failed()?;
    staged.commit()?;
    ui.note(format!("wrote a virtual record of {} places of the heat source", args.places.len()));
    Ok(())
}
