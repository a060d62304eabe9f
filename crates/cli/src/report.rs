//! `rijke report`: figures, tables and the page from the numbers of the studies.

use crate::{
    failure::{Classify, Failure},
    staging::Lock,
    ui::Ui,
};
use rijke_report::{Numbers, Report, ReportError};
use std::path::PathBuf;

/// Draw the figures and write the page from the numbers of a ranking.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  rijke rank virtual-rig --out results\n  rijke report results\n\n\
    Reads DIR/numbers/*.json. Writes DIR/index.html, DIR/figures/*.svg and DIR/tables/*.csv.\n\
    The same numbers give the same bytes.")]
pub(crate) struct Args {
    /// The folder of results, as written by `rijke rank`.
    dir: PathBuf,
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failure> {
    let _lock = args.dir.is_dir().then(|| Lock::take(&args.dir)).transpose()?;
    let folder = args.dir.join("numbers");
    let rank_first = format!("Run `rijke rank RECORDS --out {}` first.", args.dir.display());
    let numbers = Numbers::read(&folder).or_bad_input().map_err(|f| f.remedy(&rank_first))?;
    let report = Report::new(&numbers);
    if matches!(report, Err(ReportError::Nothing)) {
        return report.map(drop).or_bad_input().map_err(|f| f.at(&folder).remedy(&rank_first));
    }
    report.or_failed()?.write(&args.dir).or_failed()?;
    let page = args.dir.join("index.html");
    ui.say(page.display().to_string());
    ui.result(&serde_json::json!({ "page": page }))
}
