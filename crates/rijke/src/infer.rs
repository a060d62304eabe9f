//! `rijke infer`: unknown numbers of network files from one table of measured modes, and which file explains
//! them best. A short way to say a study of one stage.

use crate::ui::Ui;
use rijke_engine::folder::{InferredNetwork, infer_networks};
use rijke_engine::run::Trusted;
use rijke_engine::told::{not_decided, not_identified};
use rijke_numerics::{Failed, StagedFolder, write_output};
use serde_json::json;
use std::{f64::consts::TAU, path::PathBuf};

/// Infer unknown numbers of acoustic networks (a flame's gain and delay, an end's loss, a length) from
/// measured growth rates, frequencies and mode shapes, and rank the networks by evidence.
#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  rijke infer examples/ducted-flame/n-tau.toml examples/ducted-flame/second-order.toml \
    --data examples/ducted-flame/modes.csv --fitted fitted.toml\n\n\
    FILE is a network file (docs/network-file.md) with \"$name\" in the place of some numbers. Such a name is an unknown, whose prior\n\
    stands in [unknown.name], or a factor, which is a column of the data. The noise is the stated one plus a model error whose size is\n\
    inferred, one for growth rates and one for frequencies. `--study DIR` writes the best file as a study of one stage, for `rijke run DIR`."
)]
pub(crate) struct Args {
    /// Network files that compete.
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Measured modes, one per row: growth_rate, frequency and pressures as in observations/modes.csv, each
    /// with its standard deviation, and a column for every factor that the files name.
    #[arg(long, value_name = "CSV")]
    data: PathBuf,
    /// Write the network with the most evidence. Unknowns take their most probable values, and factors those
    /// of the row with the largest predicted growth rate.
    #[arg(long, value_name = "FILE", value_parser = crate::figure::any_file)]
    fitted: Option<PathBuf>,
    /// Write the network with the most evidence and the data as the folder of a study.
    #[arg(long, value_name = "DIR")]
    study: Option<PathBuf>,
    /// Search for one maximum of each posterior, and check nothing. This is faster, and wrong where a
    /// posterior has several maxima.
    #[arg(long)]
    one_start: bool,
    /// Replace DIR if it exists.
    #[arg(long, requires = "study")]
    force: bool,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failed> {
    let staged =
        args.study.as_ref().map(|dir| StagedFolder::new(dir, "study.toml", args.force)).transpose()?;
    let trusted = if args.one_start { Trusted::Laplace } else { Trusted::Checked };
    let found = infer_networks(&args.files, &args.data, trusted, ui)?;
    print(ui, &found);
    let Some(best) = found.first() else { return ui.result(&json!([])) };
    if let Some(path) = &args.fitted {
        write_output(path, best.fitted()?.as_bytes())?;
        ui.note(format!("wrote {}", path.display()));
    }
    if let (Some(staged), Some(dir)) = (staged, &args.study) {
        best.write_study(staged.path())?;
        staged.commit()?;
        ui.note(format!("wrote {}; `rijke run {}` makes its page", dir.display(), dir.display()));
    }
    ui.result(&found.iter().map(InferredNetwork::json).collect::<Vec<_>>())
}

fn print(ui: &Ui, found: &[InferredNetwork]) {
    ui.say(format!("{} measured modes", found.first().map_or(0, |f| f.stage.measured.len())));
    let row = |f: &InferredNetwork| {
        let e = f.evidence;
        let numbers = [e.ln_best_fit, e.ln_occam, e.ln_marginal].map(|ln| format!("{ln:.2}"));
        numbers.into_iter().chain([f.file.display().to_string()])
    };
    ui.table(["ln BFL", "ln OF", "ln ML", "network"], found.iter().map(row));
    if let [best, next, ..] = found
        && let lead = best.evidence.ln_marginal - next.evidence.ln_marginal
        && let decides = best.stage.decides
        && lead < decides
    {
        let files = [best, next].map(|found| found.file.display().to_string());
        ui.say(not_decided([&files[0], &files[1]], lead, decides));
    }
    for f in found {
        ui.say(format!("{}:", f.file.display()));
        for p in &f.model().parameters {
            ui.say(format!("  {}", p.words()));
            not_identified(p, f.stage.missed.is_some())
                .iter()
                .for_each(|said| ui.say(format!("      {said}")));
        }
        let [growth, frequency, _] = f.model().misfit;
        ui.say(format!("  model error: {growth:.3} 1/s, {:.3} Hz", frequency / TAU));
        f.remarks().iter().for_each(|remark| ui.say(format!("  check: {remark}")));
    }
}
