//! `rijke report`: figures, tables and the page from the numbers of a ranking.

use crate::ui::Ui;
use rijke_engine::folder::warn_of_study;
use rijke_numerics::Failed;
use rijke_report::draw_study;
use std::path::PathBuf;

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

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failed> {
    warn_of_study(&args.dir, ui);
    let page = draw_study(&args.dir)?;
    ui.say(page.display().to_string());
    ui.result(&serde_json::json!({ "page": page }))
}
