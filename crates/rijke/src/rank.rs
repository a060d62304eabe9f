//! `rijke rank`: trains the stages of a study on its observations, and answers its questions.

use crate::{trust::Trust, ui::Ui};
use rijke_engine::folder::{
    RankOptions, ResponseResults, doubts_of, known_stage, observations, open_study, rank, rank_responses,
};
use rijke_engine::told::{doubts_of_stage, tell_stage};
use rijke_intake::foresee;
use rijke_numerics::{Failed, StagedFolder, Tell};
use rijke_report::write_response_page;
use rijke_study::Study;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Train the stages of a study, rank their models by evidence, and answer the questions of study.toml.
#[derive(clap::Args)]
#[command(after_help = "Example:\n  rijke rank examples/quarter-wave\n\n\
    Reads DIR/observations. Writes DIR/results/numbers, from which `rijke report DIR` draws, and DIR/results/models,\n\
    with which `rijke predict DIR` predicts and\n\
    `rijke next DIR` says what to measure next.")]
pub(crate) struct Args {
    /// Folder of the study.
    dir: PathBuf,
    #[command(flatten)]
    trust: Trust,
    /// Stop after this stage, and answer only the questions about the stages that have run.
    #[arg(long, value_name = "STAGE")]
    until: Option<String>,
    /// Say what errors of lengths that rig.toml states as plain numbers would turn the lead of each stage;
    /// takes about as long again.
    #[arg(long)]
    lengths: bool,
    /// Replace DIR/results if it exists.
    #[arg(long)]
    force: bool,
}

impl Args {
    /// All stages of a study.
    pub(crate) fn of(dir: &Path, trust: Trust, force: bool) -> Self {
        Self { dir: dir.to_owned(), trust, until: None, lengths: false, force }
    }
}

pub(crate) fn run(args: &Args, ui: &Ui) -> Result<(), Failed> {
    let dir = &args.dir;
    let study = open_study(dir)?;
    if study.plan.stages.is_empty() {
        return of_responses(study, args, ui);
    }
    let (observations, doubts) = (observations(&study)?, doubts_of(&study));
    let staged = StagedFolder::new(&dir.join("results"), "numbers/claims.json", args.force)?;
    ui.after_killed_run(&staged);
    let (trusted, until) = (args.trust.trusted()?, args.until.as_deref());
    let foresee = |study: &mut Study, places: &[usize]| foresee(study, places, ui);
    let options = RankOptions { trusted, until, lengths: args.lengths, foresee: &foresee };
    let (results, responses) = rank(study.clone(), &observations, &options, staged.path(), ui)?;
    if let Some(responses) = &responses {
        write_response_page(&study.plan, responses, &staged.path().join(ResponseResults::BESIDE_MODES))?;
    }
    staged.commit()?;
    results.stages.iter().for_each(|stage| tell_stage(stage, ui));
    let exact = study.taken_as_exact();
    exact.iter().for_each(|said| ui.say(said));
    for v in &results.verdicts {
        ui.say(format!("{}: {} ({})", if v.holds { "holds" } else { "fails" }, v.statement, v.figure));
    }
    let stages = results.stages.iter().map(|stage| {
        let mut all = json!(stage);
        all["doubts"] = doubts_of_stage(stage).into();
        all
    });
    let stages: Vec<Value> = stages.collect();
    let mut result = json!({
        "dir": dir.join("results"),
        "stages": stages,
        "claims": results.verdicts,
        "doubts": doubts,
        "exact": exact,
    });
    if let Some(responses) = responses {
        result["responses"] = responses.shorts().into();
    }
    ui.result(&result)
}

/// Of a study all of whose stages train on responses.
fn of_responses(mut study: Study, args: &Args, ui: &Ui) -> Result<(), Failed> {
    if args.trust.has_sampler() {
        return Err(Failed::bad_input("--sampler: the stages of this study train on responses, whose evidence has no sampler")
            .at(&study.folder)
            .remedy("Leave it out; `checked = true` in a stage of study.toml looks for further maxima and checks the evidence."));
    }
    if let Some(id) = &args.until {
        let ids: Vec<&str> = study.plan.responses.iter().map(|s| s.id.as_str()).collect();
        let last = known_stage(id, &ids, &study.folder)?;
        study.plan.responses.truncate(last + 1);
    }
    let results = study.folder.join("results");
    let staged = StagedFolder::new(&results, "index.html", args.force)?;
    ui.after_killed_run(&staged);
    let plan = study.plan.clone();
    let (responses, _) = rank_responses(study, args.trust.trusted()?, staged.path(), ui)?;
    write_response_page(&plan, &responses, staged.path())?;
    staged.commit()?;
    ui.result(&json!({ "page": results.join("index.html"), "stages": responses.shorts() }))
}
