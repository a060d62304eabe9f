//! `rijke flow`: from click arrival times to the base flow.

use crate::{number, ui::Ui};
use rijke_flow::Closures;
use rijke_flow::assimilate::{self, AssimilationMethod};
use rijke_flow::shown::{together, words};
use rijke_intake::{FlowOptions, InferredFlow};
use rijke_numerics::{Classify, Failed, StagedFolder, Tell};
use rijke_report::flow_page;
use std::path::{Path, PathBuf};

/// Infer velocity, temperature and sound speed along the tube from clicks or thermometers.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  rijke process virtual-rig --out observations && rijke flow observations --out base-flow\n  rijke flow --twin --out clicks && rijke flow clicks --out base-flow\n\n\
    Reads DIR/observations (or DIR itself) as `rijke process` writes them: the mean clicks of settled operating points.\n\
    tube.toml beside them describes the heated tube.\n\
    Three files may lie beside them. readings.csv has thermometers or speeds of sound along the tube; they count with the clicks,\n\
    or alone. ramps.csv says which points were measured while the power changed, and when; their base flow is that of the moment.\n\
    profiles.csv has temperatures or sound speeds along the tube; then the base flow is that profile, and nothing is inferred.\n\
    Instead of all this, DIR/flow.toml names CSV files of samples: a record over time, warm-up included.\n\
    Writes OUT/states.json (the states that a study reads from DIR/base), OUT/base-states.json (a base state per operating\n\
    point with its errors, for acoustics), OUT/flow.json (parameters, velocities and profiles with sd, for figures), OUT/unknowns.csv and\n\
    OUT/velocity.csv."
)]
pub(crate) struct Args {
    /// Folder of observations, or of samples over time.
    #[arg(required_unless_present = "twin")]
    dir: Option<PathBuf>,
    /// Folder to write.
    #[arg(long, value_name = "DIR")]
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

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failed> {
    let closures = args.closures.as_deref().map_or(Ok(Closures::default()), read_closures)?;
    let Some(dir) = args.dir.as_deref().filter(|_| !args.twin) else { return twin(args, &closures, ui) };
    let (method, filters) = match args.method {
        Choice::Batch => (AssimilationMethod::Batch, false),
        Choice::Smoother => (AssimilationMethod::Smoother, false),
        Choice::Paper => (AssimilationMethod::Paper, true),
        Choice::SquareRoot => (AssimilationMethod::SquareRoot, true),
    };
    let beside = args.plot && filters;
    let options = FlowOptions { method, separate: args.separate, beside, closures, seed: args.seed };
    let plots = |flow: &InferredFlow, folder: &Path| match args.plot {
        true => flow_page(&flow.document, &flow.beside, &folder.join("plots")),
        false => Ok(()),
    };
    let flow = infer(dir, &args.out, args.force, &options, &plots, ui)?;
    ui.result(&flow.document)
}

/// Infers the base flow of a study with the usual options; when its ramps are settled, in words.
pub(crate) fn of_study(dir: &Path, out: &Path, force: bool, tell: &dyn Tell) -> Result<Vec<String>, Failed> {
    Ok(infer(dir, out, force, &FlowOptions::default(), &|_, _| Ok(()), tell)?.settling())
}

/// Infers, writes and says it.
fn infer(
    dir: &Path,
    out: &Path,
    force: bool,
    options: &FlowOptions,
    plots: &dyn Fn(&InferredFlow, &Path) -> Result<(), Failed>,
    tell: &dyn Tell,
) -> Result<InferredFlow, Failed> {
    let flow = InferredFlow::infer(dir, options, tell)?;
    flow.write(out, force, &|folder| plots(&flow, folder), tell)?;
    let runs = &flow.document.runs;
    runs.iter().flat_map(words).chain(together(runs)).chain(flow.settling()).for_each(|said| tell.say(said));
    Ok(flow)
}

fn read_closures(path: &Path) -> Result<Closures, Failed> {
    let text = rijke_numerics::read_text(path).or_bad_input().map_err(|f| f.at(path))?;
    rijke_rig::files::parse_toml(&text, path).or_bad_input()
}

/// Writes a virtual record.
fn twin(args: &Args, closures: &Closures, ui: &Ui) -> Result<(), Failed> {
    let records = assimilate::twins(closures, &args.places, args.seed).or_bad_input()?;
    let staged = StagedFolder::new(&args.out, "flow.toml", args.force)?;
    records.write(staged.path()).or_failed()?;
    staged.commit()?;
    ui.note(format!("wrote a virtual record; places of the heat source: {}", args.places.len()));
    Ok(())
}
