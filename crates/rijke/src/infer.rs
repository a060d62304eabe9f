//! `rijke infer`: unknown numbers of network files from one table of measured modes, and which file explains
//! them best. A short way to say a study of one stage.

use crate::{
    failure::{Classify, Failure},
    number,
    results::reasons,
    study::{of_the_engine, warn_of_copies, warn_of_doubts},
    ui::Ui,
};
use rijke_engine::SavedModel;
use rijke_engine::run::{EvidenceRecord, FarOff, MeasuredRecord, ModelRecord, Run, StageRecord, Trusted};
use rijke_numerics::{StagedFolder, write_output};
use rijke_study::{OneTable, Study, filled_rig};
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
    /// Write the file with the most evidence, its unknowns at their most probable values (factors as in the
    /// row with the highest growth rate).
    #[arg(long, value_name = "FILE")]
    fitted: Option<PathBuf>,
    /// Write the file with the most evidence and the data as the folder of a study.
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

/// A network file and what was inferred of it.
struct Found {
    file: PathBuf,
    table: OneTable,
    study: Study,
    stage: StageRecord,
    evidence: EvidenceRecord,
    saved: SavedModel,
}

impl Found {
    fn model(&self) -> &ModelRecord {
        &self.stage.models[0]
    }
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failure> {
    let staged =
        args.study.as_ref().map(|dir| StagedFolder::new(dir, "study.toml", args.force)).transpose()?;
    // All files are read before the first is trained.
    let studies = args.files.iter().map(|file| {
        let table = OneTable::read(file, &args.data).or_bad_input()?;
        let read = table.study().or_bad_input()?;
        if read.0.rig.own.parameters.is_empty() {
            return Err(Failure::bad_input("has no unknown").at(file).remedy(
                "Write \"$name\" in the place of a number, and give [unknown.name] with prior = { normal = { mean = ..., sd = ... } }.",
            ));
        }
        Ok((file, table, read))
    });
    let studies = studies.collect::<Result<Vec<_>, _>>()?;
    studies.iter().for_each(|(_, _, (study, _))| warn_of_doubts(ui, study));
    if let Some((_, _, (study, observations))) = studies.first() {
        warn_of_copies(ui, study, observations);
    }
    let progress = ui.progress("networks", studies.len() as u64);
    let trusted = if args.one_start { Trusted::Laplace } else { Trusted::Checked };
    let (mut found, mut without) = (Vec::new(), Vec::new());
    for (file, table, (study, observations)) in studies {
        // Points are called by their lines.
        let wrong = |e: rijke_engine::EngineError| match e.point().and_then(|p| p.strip_prefix("line-")) {
            Some(line) => Failure::bad_input(format!("{}, line {line}: {e}", args.data.display()))
                .remedy(format!("Correct that row, or {} where it uses its numbers.", file.display())),
            None => of_the_engine(&e, file),
        };
        let trained = || {
            let mut run = Run::new(study.clone(), &observations, trusted).map_err(wrong)?;
            let stage = run.next_stage().map_err(wrong)?;
            let stage = stage.ok_or_else(|| Failure::failed("no stage was run").at(file))?;
            let Some(evidence) = stage.models[0].evidence else {
                let why = stage.models[0].remark.clone().unwrap_or_default();
                return Err(Failure::failed(format!("the most probable unknowns were not found: {why}"))
                    .at(file)
                    .remedy("Give priors nearer to the truth, or fewer unknowns."));
            };
            Ok((stage, evidence, run.saved("modes").map_err(wrong)?))
        };
        match trained() {
            Ok((stage, evidence, saved)) => {
                found.push(Found { file: file.clone(), table, study, stage, evidence, saved });
            }
            Err(failure) => without.push(failure),
        }
        progress.advance(1);
    }
    drop(progress);
    if found.is_empty()
        && let Some(failure) = without.pop()
    {
        return Err(failure);
    }
    without.iter().for_each(|failure| ui.note(format!("no evidence: {failure}")));
    found.sort_by(|a, b| b.evidence.ln_marginal.total_cmp(&a.evidence.ln_marginal));
    print(ui, &found);
    let Some(best) = found.first() else { return ui.result(&json!([])) };
    if let Some(path) = &args.fitted {
        write_output(path, fitted(best)?.as_bytes())?;
        ui.note(format!("wrote {}", path.display()));
    }
    if let (Some(staged), Some(dir)) = (staged, &args.study) {
        keep(best, &staged)?;
        staged.commit()?;
        ui.note(format!("wrote {}; `rijke run {}` makes its page", dir.display(), dir.display()));
    }
    let answers = found.iter().map(|f| {
        let e = f.evidence;
        let [growth, frequency, pressure] = f.model().misfit;
        let unknowns = f.model().parameters.iter();
        let unknowns =
            unknowns.map(|p| json!({ "name": p.name, "unit": p.unit, "value": p.value, "sd": p.sd }));
        json!({
            "file": f.file, "ln_best_fit": e.ln_best_fit, "ln_occam": e.ln_occam, "ln_marginal": e.ln_marginal,
            "unknowns": unknowns.collect::<Vec<_>>(),
            "model_error": { "growth_rate": growth, "frequency_hz": frequency / TAU, "pressure": pressure },
            "covariance": covariance(&f.saved),
            "residuals": residuals(f),
            "remark": f.model().remark,
        })
    });
    ui.result(&answers.collect::<Vec<_>>())
}

/// Names of what was inferred, in the order of rows and columns, and the covariance.
fn covariance(saved: &SavedModel) -> Option<serde_json::Value> {
    let known = saved.posterior().ok()?.gaussian;
    let n = known.names.len();
    let rows: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| known.covariance[(i, j)]).collect()).collect();
    Some(json!({ "names": known.names, "rows": rows }))
}

/// Measured less predicted, for every row of the table, by its line.
fn residuals(found: &Found) -> Vec<serde_json::Value> {
    let less = |measured: Option<[f64; 2]>, predicted: f64| measured.map(|m| m[0] - predicted);
    let of = |(m, p): (&MeasuredRecord, &[f64; 2])| {
        let omega = less(m.angular_frequency, p[1]);
        json!({
            "row": m.point, "mode": m.mode, "growth_rate": less(m.growth_rate, p[0]),
            "frequency_hz": omega.map(|omega| omega / TAU),
        })
    };
    found.stage.measured.iter().zip(found.model().shown()).map(of).collect()
}

fn print(ui: &Ui, found: &[Found]) {
    ui.say(format!("{} measured modes", found.first().map_or(0, |f| f.stage.measured.len())));
    let row = |f: &Found| {
        let e = f.evidence;
        let numbers = [e.ln_best_fit, e.ln_occam, e.ln_marginal].map(|ln| format!("{ln:.2}"));
        numbers.into_iter().chain([f.file.display().to_string()])
    };
    ui.table(["ln BFL", "ln OF", "ln ML", "network"], found.iter().map(row));
    for f in found {
        ui.say(format!("{}:", f.file.display()));
        for p in &f.model().parameters {
            ui.say(format!("  {} = {}", p.name, number::quantity(p.value, p.sd, &p.unit)));
        }
        let [growth, frequency, _] = f.model().misfit;
        ui.say(format!("  model error: {growth:.3} 1/s, {:.3} Hz", frequency / TAU));
        let far = FarOff::of(&f.stage.measured, f.model()).map(|far| far.words());
        let remarks = far.iter().map(String::as_str).chain(reasons(&f.model().remark));
        remarks.for_each(|remark| ui.say(format!("  check: {remark}")));
    }
}

/// The files of a study of one stage.
fn keep(best: &Found, staged: &StagedFolder) -> Result<(), Failure> {
    let origin = "kind = \"measured\"\nsource = \"the table of `rijke infer`\"\n";
    let files = [
        ("rig.toml", best.table.rig.as_str()),
        ("campaign.csv", &best.table.campaign),
        ("study.toml", &best.table.plan),
        ("observations/modes.csv", &best.table.modes),
        ("observations/observations.toml", origin),
    ];
    for (name, text) in files {
        let path = staged.path().join(name);
        let made = path.parent().map_or(Ok(()), std::fs::create_dir_all);
        made.and_then(|()| std::fs::write(&path, text)).or_failed().map_err(|f| f.at(&path))?;
    }
    Ok(())
}

/// The network file with numbers in the place of unknowns and factors.
fn fitted(best: &Found) -> Result<String, Failure> {
    let growth = |k: &usize| best.stage.measured[*k].growth_rate.map_or(f64::NEG_INFINITY, |g| g[0]);
    let row = (0..best.stage.measured.len()).max_by(|a, b| growth(a).total_cmp(&growth(b))).unwrap_or(0);
    let factors = best.study.campaign.factors.iter().zip(&best.stage.measured[row].factors);
    let mut numbers: Vec<(&str, f64)> =
        best.model().parameters.iter().map(|p| (p.name.as_str(), p.value)).collect();
    numbers.extend(factors.filter_map(|(f, v)| Some((f.name.as_str(), (*v)?))));
    filled_rig(&best.table.rig, &numbers).or_failed()
}
