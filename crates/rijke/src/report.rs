//! `rijke report`: figures, tables and the page from the numbers of a ranking.

use crate::{
    failure::{Classify, Failure},
    rank::{Results, rival_of},
    results::kept,
    study::{observations, open, warn_of_study},
    ui::Ui,
};
use rijke_engine::SavedModel;
use rijke_engine::run::{Sliders, StageRecord};
use rijke_numerics::Lock;
use rijke_report::{StudyHead, StudyPage};
use rijke_study::{ObservedModes, Study};
use std::path::{Path, PathBuf};

/// Draw the figures and write the page of a study from the numbers of its ranking.
#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  rijke rank examples/quarter-wave\n  rijke report examples/quarter-wave\n\n\
    Reads DIR/results/numbers. Writes DIR/results/index.html, figures/*.svg, figures/*.pdf and tables/*.csv beside it.\n\
    The same numbers give the same bytes."
)]
pub(crate) struct Args {
    /// Folder of the study.
    dir: PathBuf,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failure> {
    warn_of_study(&args.dir, ui);
    let page = draw(&args.dir)?;
    ui.say(page.display().to_string());
    ui.result(&serde_json::json!({ "page": page }))
}

/// Writes the page of a study that was ranked.
pub(crate) fn draw(dir: &Path) -> Result<PathBuf, Failure> {
    let study = open(dir)?;
    if study.plan.stages.is_empty() {
        return crate::study_responses::report(&study);
    }
    if !study.plan.responses.is_empty() {
        crate::study_responses::report(&study)?;
    }
    let observations = observations(&study)?;
    let Results { stages, answers, verdicts } = Results::read(dir, &study.plan)?;
    let head = StudyHead::of(&study, &observations);
    let results = dir.join("results");
    let sliders = sliders(&study, &observations, &stages);
    let _lock = Lock::take(&results)?;
    StudyPage::new(&head, &stages, &answers, &verdicts, sliders.as_ref())
        .or_failed()?
        .write(&results)
        .or_failed()?;
    Ok(results.join("index.html"))
}

/// The model that went on from the last stage at which models competed, or from the last, as the page solves
/// it; a sentence that says why it cannot. None where no such model was kept.
fn sliders(
    study: &Study,
    observations: &ObservedModes,
    stages: &[StageRecord],
) -> Option<(String, Result<Sliders, String>)> {
    let competed = |s: &&StageRecord| s.models.iter().filter(|m| m.evidence.is_some()).count() > 1;
    let stage = stages.iter().rfind(competed).or(stages.last())?;
    let saved: SavedModel = kept(&study.folder, "models", &stage.id).ok()?;
    let solved = |model: &SavedModel| rijke_engine::run::sliders(study, observations, stage, model);
    let found = solved(&saved).or_else(|why| {
        let rival: SavedModel =
            kept(&study.folder, "models", &rival_of(&stage.id)).map_err(|_| why.clone())?;
        let mut next = solved(&rival).map_err(|_| why.clone())?;
        next.instead = Some(why);
        Ok(next)
    });
    Some((stage.id.clone(), found))
}
