//! `rijke rank`: train the candidates on observations and rank them.

use crate::{
    failure::{Classify, Failure},
    staging::StagedFolder,
    ui::Ui,
};
use rijke_lab::Truth;
use rijke_rig::{DataKind, Observations};
use rijke_studies::{
    Check, Prongs, campaign, cold_heater, consistency, empty_tube, lumped_convergence, microphones,
    prongs_and_knowledge, true_empty_tube,
};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Train the candidate models on observations, rank them by evidence, and answer the questions of the studies.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  rijke rank virtual-rig --out results\n\n\
    Reads DIR/observations (or DIR itself) as `rijke process` writes them. Writes OUT/numbers/*.json, from which\n\
    `rijke report OUT` draws.")]
pub(crate) struct Args {
    /// Folder of records with their observations, or of observations.
    dir: PathBuf,
    /// Folder to write.
    #[arg(long, value_name = "OUT")]
    out: PathBuf,
    /// Truth file of the virtual laboratory, to mark true values [default: fixtures/lab/truth.toml of the project];
    /// not used for measured data.
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    /// Check every evidence by other starts, importance sampling and doubled priors; takes some ten times longer.
    #[arg(long)]
    thorough: bool,
    /// Replace OUT if it exists.
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failure> {
    let below = args.dir.join("observations");
    let folder = if below.is_dir() { &below } else { &args.dir };
    let observations = Observations::read(folder)
        .or_bad_input()
        .map_err(|f| f.remedy(format!("Run `rijke process {}` first.", args.dir.display())))?;
    let truth = args.truth.as_deref().map_or(Ok(Truth::standard()), Truth::read).or_bad_input()?;
    let virtual_data = observations.kind == DataKind::Virtual;
    let known = virtual_data.then(|| true_empty_tube(&observations, &truth)).flatten();
    let staged = StagedFolder::new(&args.out, "numbers/prongs.json", args.force)?;
    let numbers = staged.path().join("numbers");
    std::fs::create_dir_all(&numbers).or_failed().map_err(|f| f.at(&numbers))?;

    let progress = ui.progress("studies", 6);
    let wrong = |f: Failure| f.at(folder);
    let tube = empty_tube(&observations, known).or_bad_input().map_err(wrong)?;
    progress.advance(1);
    let (prongs, known_of_prongs) =
        prongs_and_knowledge(&observations, args.thorough).or_bad_input().map_err(wrong)?;
    progress.advance(1);
    // Only a campaign with the heater attached and cold can say anything of it.
    let has_heater =
        |p: &rijke_rig::PointObservations| p.point.heater && p.point.power == 0.0 && !p.point.thermocouples;
    let heater = if observations.points.iter().any(has_heater) {
        Some(
            cold_heater(&observations, &prongs.winner, &known_of_prongs, args.thorough)
                .or_bad_input()
                .map_err(wrong)?,
        )
    } else {
        None
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
    if let Some(heater) = &heater {
        write(&numbers, "heater", heater)?;
    }
    write(&numbers, "consistency", &consistency)?;
    write(&numbers, "lumped_convergence", &lumped)?;
    drop(progress);
    staged.commit()?;
    table(ui, &prongs);
    if let Some(heater) = &heater {
        table(ui, heater);
    }
    let of_heater = heater.map(|h| h.checks).unwrap_or_default();
    for check in [&tube.checks, &prongs.checks, &of_heater, &microphones.checks].into_iter().flatten() {
        say(ui, check);
    }
    Ok(())
}

fn write(folder: &Path, name: &str, numbers: &impl Serialize) -> Result<(), Failure> {
    let path = folder.join(format!("{name}.json"));
    let text = serde_json::to_string_pretty(numbers).or_failed()?;
    std::fs::write(&path, text + "\n").or_failed().map_err(|f| f.at(&path))
}

fn table(ui: &Ui, prongs: &Prongs) {
    ui.say(format!("{:<10} {:>10} {:>10} {:>10}   {}", "model", "ln BFL", "ln OF", "ln ML", "what it is"));
    for model in &prongs.models {
        let winner = if model.id == prongs.winner { " (highest evidence)" } else { "" };
        match &model.evidence {
            Some(e) => ui.say(format!(
                "{:<10} {:>10.4} {:>10.4} {:>10.4}   {}{winner}",
                model.id, e.ln_best_fit, e.ln_occam, e.ln_marginal, model.label
            )),
            None => {
                ui.say(format!("{:<10} no evidence: {}", model.id, model.remark.as_deref().unwrap_or("")))
            }
        }
    }
}

fn say(ui: &Ui, check: &Check) {
    let mark = if check.holds { "holds" } else { "fails" };
    ui.say(format!("{mark}: {} ({})", check.statement, check.figure));
}
