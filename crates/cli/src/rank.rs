//! `rijke rank`: train the candidates on observations and rank them.

mod hot;
pub(crate) mod own;

use crate::{
    check::foresight::refuse_boundless,
    failure::{Classify, Failure},
    staging::StagedFolder,
    ui::Ui,
};
use rijke_lab::Truth;
use rijke_rig::{DataKind, Observations, PointObservations};
use rijke_studies::{
    Check, Depth, ProngModel, Prongs, Terms, campaign, cold, cold_heater, consistency, empty_tube,
    flow_numerics, lumped_convergence, microphones, prongs_stage, true_empty_tube,
};
use serde::Serialize;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Train the candidate models on observations, rank them by evidence, and answer the questions of the studies.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  rijke rank virtual-rig --out results\n  \
    rijke rank virtual-rig --flow base-flow --candidates candidates.toml --out results\n\n\
    Reads DIR/observations (or DIR itself) as `rijke process` writes them. Writes OUT/numbers/*.json, from which\n\
    `rijke report OUT` draws, and with --flow the chosen model OUT/model.json.")]
pub(crate) struct Args {
    /// Folder of records with their observations, or of observations.
    dir: PathBuf,
    /// Folder to write.
    #[arg(long, value_name = "OUT")]
    out: PathBuf,
    /// Folder that `rijke flow` wrote for the same observations: the base flow of the hot points. Without it only the
    /// cold experiments are ranked.
    #[arg(long, value_name = "FLOWDIR")]
    flow: Option<PathBuf>,
    /// Files of candidates of your own, which compete with those of the project: prongs, heater, heat release.
    #[arg(long, value_name = "FILE", num_args = 1..)]
    candidates: Vec<PathBuf>,
    /// Truth file of the virtual laboratory, to mark true values [default: fixtures/lab/truth.toml of the project];
    /// not used for measured data.
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    /// Check every evidence by other starts, importance sampling and doubled priors; takes some ten times longer.
    #[arg(long)]
    thorough: bool,
    /// Compare the evidences of Tables 2 and 3 with a slow method that needs no Gaussian approximation; implies --thorough.
    #[arg(long)]
    referee: Option<crate::check_model::Judge>,
    /// Statistical error of the referee, nats; its cost grows with the inverse square.
    #[arg(long, value_name = "NATS", default_value_t = 0.3, value_parser = crate::number::positive)]
    referee_error: f64,
    /// Replace OUT if it exists.
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failure> {
    let depth = depth(args)?;
    let below = args.dir.join("observations");
    let folder = if below.is_dir() { &below } else { &args.dir };
    let observations = Observations::read(folder)
        .or_bad_input()
        .map_err(|f| f.remedy(format!("Run `rijke process {}` first.", args.dir.display())))?;
    let points: Vec<_> = observations.points.iter().map(|p| p.point.clone()).collect();
    let terms = Terms { depth, own: own::candidates(&args.candidates, &observations.rig, &points)? };
    refuse_boundless(&observations, &terms.own).map_err(|f| f.at(folder))?;
    let truth = args.truth.as_deref().map_or(Ok(Truth::standard()), Truth::read).or_bad_input()?;
    let virtual_data = observations.kind == DataKind::Virtual;
    let known = virtual_data.then(|| true_empty_tube(&observations, &truth)).flatten();
    let staged = StagedFolder::new(&args.out, "numbers/prongs.json", args.force)?;
    let numbers = staged.path().join("numbers");
    std::fs::create_dir_all(&numbers).or_failed().map_err(|f| f.at(&numbers))?;

    let progress = ui.progress("studies", 7 + args.flow.as_ref().map_or(0, |_| hot::STEPS));
    let wrong = |f: Failure| f.at(folder);
    let tube = empty_tube(&observations, known).or_bad_input().map_err(wrong)?;
    progress.advance(1);
    let (prongs, after_prongs) = prongs_stage(&observations, terms.clone()).or_bad_input().map_err(wrong)?;
    progress.advance(1);
    // Only a campaign with the heater attached and cold can say anything of it, and so on.
    let has = |thermocouples: bool| {
        let cold = |p: &PointObservations| p.point.heater && p.point.power == 0.0;
        observations.points.iter().any(|p| cold(p) && p.point.thermocouples == thermocouples)
    };
    let heater = has(false)
        .then(|| cold_heater(&observations, &after_prongs, terms.clone()))
        .transpose()
        .or_bad_input()
        .map_err(wrong)?;
    progress.advance(1);
    let cold = match &heater {
        Some((_, after_heater)) if has(true) => {
            Some(cold(&observations, after_heater).or_bad_input().map_err(wrong)?)
        }
        _ => None,
    };
    progress.advance(1);
    let microphones = microphones(&observations, known).or_bad_input().map_err(wrong)?;
    progress.advance(1);
    let consistency = consistency(&observations.rig).or_failed()?;
    progress.advance(1);
    let lumped = lumped_convergence(&observations.rig).or_failed()?;
    progress.advance(1);
    write(&numbers, "campaign", &campaign(&observations))?;
    write(&numbers, "empty_tube", &tube)?;
    write(&numbers, "prongs", &prongs)?;
    write(&numbers, "microphones", &microphones)?;
    write(&numbers, "consistency", &consistency)?;
    write(&numbers, "lumped_convergence", &lumped)?;
    if let Some((heater, _)) = &heater {
        write(&numbers, "heater", heater)?;
    }
    let (figure_5, stage) = cold.unzip();
    if let Some(figure_5) = &figure_5 {
        write(&numbers, "cold", figure_5)?;
    }
    let found = match (&args.flow, stage) {
        (Some(flow), Some(stage)) => {
            keep_flow(flow, &numbers)?;
            // The powers of the paper may be too much for another rig.
            if let Ok(numerics) = flow_numerics(&observations.rig) {
                write(&numbers, "flow_numerics", &numerics)?;
            }
            Some(hot::hot(
                &observations,
                flow,
                stage,
                Terms { depth: (args.thorough || args.referee.is_some()).into(), ..terms.clone() },
                virtual_data.then_some(&truth),
                staged.path(),
                &progress,
            )?)
        }
        (Some(_), None) => {
            let message = "the observations lack what the hot stages build on: a cold heater without and with thermocouples";
            return Err(Failure::bad_input(message)
                .at(folder)
                .remedy("Leave out --flow to rank the cold experiments."));
        }
        (None, _) => None,
    };
    drop(progress);
    staged.commit()?;
    table(ui, &prongs, &terms);
    if let Some((heater, _)) = &heater {
        table(ui, heater, &terms);
    }
    let ranked = [Some("prongs"), heater.as_ref().map(|_| "heater"), found.as_ref().map(|_| "heat-release")];
    own::left_out(ui, &terms.own, &ranked.into_iter().flatten().collect::<Vec<_>>());
    let tables = json!({
        "prongs": rows(&prongs.models),
        "heater": heater.as_ref().map(|(h, _)| rows(&h.models)),
        "heat_release": found.as_ref().map(|f| rows(f.models())),
    });
    let of_heater = heater.map(|(h, _)| h.checks).unwrap_or_default();
    let of_cold = figure_5.map(|f| f.checks).unwrap_or_default();
    let mut checks = [tube.checks, prongs.checks, of_heater, of_cold, microphones.checks]
        .into_iter()
        .flatten()
        .collect::<Vec<_>>();
    checks.iter().for_each(|check| say(ui, check));
    if let Some(found) = found {
        found.show(ui, &terms);
        checks.extend(found.into_checks());
    }
    ui.result(&json!({ "dir": args.out, "tables": tables, "checks": checks }))
}

/// The rows of a table for `--json`; evidences per operating point.
fn rows(models: &[ProngModel]) -> Vec<serde_json::Value> {
    let row =
        |m: &ProngModel| json!({ "id": m.id, "label": m.label, "evidence": m.evidence, "remark": m.remark });
    models.iter().map(row).collect()
}

/// The record of the base flow belongs to the numbers from which the report draws (Fig. 2).
fn keep_flow(flow: &Path, numbers: &Path) -> Result<(), Failure> {
    let record = flow.join("flow.json");
    if record.is_file() {
        std::fs::copy(&record, numbers.join("flow.json")).or_failed().map_err(|f| f.at(&record))?;
    }
    Ok(())
}

fn write(folder: &Path, name: &str, numbers: &impl Serialize) -> Result<(), Failure> {
    let path = folder.join(format!("{name}.json"));
    let text = serde_json::to_string_pretty(numbers).or_failed()?;
    std::fs::write(&path, text + "\n").or_failed().map_err(|f| f.at(&path))
}

/// How far the evidences of Tables 2 and 3 are checked.
fn depth(args: &Args) -> Result<Depth, Failure> {
    if !(args.referee_error > 0.0 && args.referee_error.is_finite()) {
        let problem = format!("--referee-error {} must be positive and finite", args.referee_error);
        return Err(Failure::bad_input(problem).remedy("Give a number of nats, such as 0.3; see --help."));
    }
    match args.referee {
        Some(judge) => Ok(Depth::Refereed(judge.kind()?, args.referee_error)),
        None => Ok(args.thorough.into()),
    }
}

fn table(ui: &Ui, study: &Prongs, terms: &Terms) {
    table_head(ui);
    for model in &study.models {
        table_row(ui, model, &study.winner);
    }
    // The empty tube, at 0, trains no row.
    let points = study.measured.iter().filter(|m| m.position_m > 0.0).count();
    own::standing(ui, &study.models, points, &terms.own);
}

fn table_head(ui: &Ui) {
    ui.say(format!("{:<14} {:>10} {:>10} {:>10}   {}", "model", "ln BFL", "ln OF", "ln ML", "what it is"));
}

fn table_row(ui: &Ui, model: &ProngModel, best: &str) {
    // Candidates beyond the paper have long names; their label says the same.
    let name = if model.id.contains(" + ") { "combination" } else { &model.id };
    let mark = if model.id == best { " (highest evidence)" } else { "" };
    match &model.evidence {
        Some(e) => ui.say(format!(
            "{name:<14} {:>10.4} {:>10.4} {:>10.4}   {}{mark}",
            e.ln_best_fit, e.ln_occam, e.ln_marginal, model.label
        )),
        None => {
            return ui.say(format!("{name:<14} no evidence: {}", model.remark.as_deref().unwrap_or("")));
        }
    }
    if let Some(remark) = &model.remark {
        ui.say(format!("{:<14} {remark}", ""));
    }
}

fn say(ui: &Ui, check: &Check) {
    let mark = if check.holds { "holds" } else { "fails" };
    ui.say(format!("{mark}: {} ({})", check.statement, check.figure));
}
