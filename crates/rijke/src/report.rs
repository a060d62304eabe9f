//! `rijke report`: figures, tables and the page from the numbers of a ranking.

use crate::{
    failure::{Classify, Failure},
    rank::Results,
    staging::Lock,
    study::{observations, open},
    ui::Ui,
};
use rijke_report::{StudyHead, StudyPage};
use std::path::{Path, PathBuf};

/// Draw the figures and write the page of a study from the numbers of its ranking.
#[derive(clap::Args)]
#[command(
    after_help = "Example:\n  rijke rank examples/quarter-wave\n  rijke report examples/quarter-wave\n\n\
    Reads DIR/results/numbers. Writes DIR/results/index.html, figures/*.svg and tables/*.csv beside it.\n\
    The same numbers give the same bytes."
)]
pub(crate) struct Args {
    /// Folder of the study.
    dir: PathBuf,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failure> {
    let page = draw(&args.dir)?;
    ui.say(page.display().to_string());
    ui.result(&serde_json::json!({ "page": page }))
}

/// Writes the page of a study that was ranked.
pub(crate) fn draw(dir: &Path) -> Result<PathBuf, Failure> {
    let study = open(dir)?;
    if !study.plan.responses.is_empty() {
        return crate::study_responses::report(&study);
    }
    let observations = observations(&study)?;
    let Results { stages, answers, verdicts } = Results::read(dir, &study.plan)?;
    let head = StudyHead::of(&study, &observations);
    let results = dir.join("results");
    let _lock = Lock::take(&results)?;
    StudyPage::new(&head, &stages, &answers, &verdicts).or_failed()?.write(&results).or_failed()?;
    Ok(results.join("index.html"))
}
