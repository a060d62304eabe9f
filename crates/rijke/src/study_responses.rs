//! Stages of a study folder that train on responses, run from its files to their page.

mod check;

pub(crate) use check::check;

use crate::{
    failure::{Classify, Failure},
    number,
    results::{Trust, kept, known_stage, warn_of_prior},
    study::{doubts_of, warn_of_doubts},
    ui::Ui,
};
use rijke_engine::EngineError;
use rijke_engine::response::{Ground, ResponseModelRecord, ResponseRun, ResponseStageRecord};
use rijke_numerics::{Lock, StagedFolder, write_output};
use rijke_report::{StudyHead, response_page};
use rijke_rig::DataKind;
use rijke_study::Study;
use rijke_study::plan::Plan;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::path::{Path, PathBuf};

/// What the page says of the data, kept beside the numbers so that it can be drawn again.
#[derive(Serialize, Deserialize)]
struct Data {
    kind: DataKind,
    source: String,
    doubts: Vec<String>,
}

/// The file of it, within the results.
const DATA: &str = "data.json";

/// Where the results of stages of responses are, within those of a study that has stages of modes as well.
const BESIDE_MODES: &str = "responses";

/// Runs the stages of a study in order, and writes their numbers and the page into its folder `results`.
pub(crate) fn run(
    mut study: Study,
    trust: Trust,
    until: Option<&str>,
    force: bool,
    ui: &Ui,
) -> Result<(), Failure> {
    let dir = study.folder.clone();
    if trust.has_sampler() {
        return Err(Failure::bad_input("--sampler: the stages of this study train on responses, whose evidence has no sampler")
            .at(&dir)
            .remedy("Leave it out; `checked = true` in a stage of study.toml looks for further maxima and checks the evidence."));
    }
    if let Some(id) = until {
        let ids: Vec<&str> = study.plan.responses.iter().map(|s| s.id.as_str()).collect();
        let last = known_stage(id, &ids, &dir)?;
        study.plan.responses.truncate(last + 1);
    }
    let results = dir.join("results");
    let staged = ui.started(StagedFolder::new(&results, "index.html", force)?);
    let (stages, _) = trained(study, trust, staged.path(), ui)?;
    staged.commit()?;
    stages.iter().for_each(|stage| table(ui, stage));
    ui.result(&json!({ "page": results.join("index.html"), "stages": shorts(&stages) }))
}

/// Trains the stages of responses of a study that has stages of modes as well, and writes their numbers and
/// their page into a folder of their own within `results`.
pub(crate) fn before_modes(
    study: Study,
    trust: Trust,
    results: &Path,
    ui: &Ui,
) -> Result<(Vec<ResponseStageRecord>, Vec<Ground>), Failure> {
    if trust.has_sampler() {
        ui.note("--sampler judges the stages of modes alone: evidence of responses has no sampler");
    }
    let found = trained(study, trust, &results.join(BESIDE_MODES), ui)?;
    found.0.iter().for_each(|stage| table(ui, stage));
    Ok(found)
}

/// Every stage without its curves.
pub(crate) fn shorts(stages: &[ResponseStageRecord]) -> Vec<serde_json::Value> {
    stages.iter().map(short).collect()
}

/// Trains the stages of responses in order; numbers and page go into `folder`.
fn trained(
    mut study: Study,
    trust: Trust,
    folder: &Path,
    ui: &Ui,
) -> Result<(Vec<ResponseStageRecord>, Vec<Ground>), Failure> {
    let dir = study.folder.clone();
    if trust.is_one_start() {
        study.plan.responses.iter_mut().for_each(|stage| stage.checked = false);
    }
    let observed = study.responses().or_bad_input()?;
    if study.plan.stages.is_empty() {
        warn_of_doubts(ui, &study);
    }
    for warning in &observed.warnings {
        ui.note(format!("warning: {warning}"));
    }
    let doubts = doubts_of(&study).into_iter().chain(observed.warnings.iter().cloned()).collect();
    let data = Data { kind: observed.kind, source: observed.source.clone(), doubts };
    let plan = study.plan.clone();
    let mut run = ResponseRun::new(study, observed).map_err(|e| fault(&e, &dir))?;
    let progress = ui.progress("models", run.models_of_all() as u64);
    let mut stages: Vec<ResponseStageRecord> = Vec::new();
    while let Some(stage) = run.next_stage_with(&|| progress.advance(1)).map_err(|e| fault(&e, &dir))? {
        stages.push(stage);
    }
    drop(progress);
    write(&folder.join(DATA), &(serde_json::to_string(&data).or_failed()? + "\n"))?;
    for stage in &stages {
        let path = folder.join("numbers").join(format!("{}.json", stage.id));
        write(&path, &(serde_json::to_string(stage).or_failed()? + "\n"))?;
    }
    page(&plan, data, &stages, folder)?;
    Ok((stages, run.grounds()))
}

/// Draws the page of a study again from the numbers of its ranking.
pub(crate) fn report(study: &Study) -> Result<PathBuf, Failure> {
    let dir = &study.folder;
    let whole = dir.join("results");
    let beside = !study.plan.stages.is_empty();
    let results = if beside { whole.join(BESIDE_MODES) } else { whole.clone() };
    let within = |folder: &str| if beside { format!("{BESIDE_MODES}/{folder}") } else { folder.to_owned() };
    let stages = study.plan.responses.iter().map(|s| s.id.as_str());
    let there = |id: &&str| results.join("numbers").join(format!("{id}.json")).is_file();
    let stages: Vec<ResponseStageRecord> =
        stages.filter(there).map(|id| kept(dir, &within("numbers"), id)).collect::<Result<_, _>>()?;
    let data: Data = kept(dir, &within(""), DATA.trim_end_matches(".json"))?;
    let _lock = Lock::take(&whole)?;
    page(&study.plan, data, &stages, &results)?;
    Ok(results.join("index.html"))
}

/// Writes the page of a study with its figures.
fn page(plan: &Plan, data: Data, stages: &[ResponseStageRecord], folder: &Path) -> Result<(), Failure> {
    let head = StudyHead {
        name: plan.name.clone(),
        question: plan.question.clone(),
        kind: data.kind,
        source: data.source,
        claims: rijke_study::Claims::default(),
        factors: Vec::new(),
        beside: None,
    };
    for (name, content) in response_page(&head, &data.doubts, stages).or_failed()? {
        let path = folder.join(name);
        path.parent().map_or(Ok(()), std::fs::create_dir_all).or_failed().map_err(|f| f.at(&path))?;
        write_output(&path, &content)?;
    }
    Ok(())
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    let folder = path.parent().map_or(Ok(()), std::fs::create_dir_all);
    folder.and_then(|()| std::fs::write(path, text)).or_failed().map_err(|f| f.at(path))
}

fn fault(error: &EngineError, dir: &Path) -> Failure {
    match error {
        EngineError::Inference(_) | EngineError::Dense(_) => Failure::failed(error).at(dir),
        EngineError::Refused { .. } | EngineError::NoPoint { .. } => {
            Failure::bad_input(error).at(&dir.join("study.toml"))
        }
        EngineError::NoWinner { .. } => Failure::bad_input(error).at(dir).remedy(
            "Check signs, units and reference of the data with `rijke check`, and the priors; a noise that is stated too small makes every \
             model impossible: let it be inferred.",
        ),
        _ => Failure::bad_input(error).at(dir),
    }
}

/// A stage without its curves.
fn short(stage: &ResponseStageRecord) -> serde_json::Value {
    let model = |m: &ResponseModelRecord| {
        json!({ "id": m.id, "evidence": m.evidence, "parameters": m.parameters, "noise": m.noise, "residual": m.residual,
                "neighbours": m.neighbours, "remark": m.remark })
    };
    json!({ "id": stage.id, "winner": stage.winner, "models": stage.models.iter().map(model).collect::<Vec<_>>() })
}

/// The models of a stage, best first.
fn table(ui: &Ui, stage: &ResponseStageRecord) {
    let count: usize = stage.loads.iter().map(|l| l.frequency_hz.len()).sum();
    let all: usize = stage.loads.iter().map(|l| l.of).sum();
    ui.say(format!(
        "{} ({}, {count} of the {all} complex numbers in their files)",
        stage.title,
        number::counted(stage.loads.len(), "response")
    ));
    let models = stage.by_evidence();
    let best = models.first().map_or(0.0, |m| m.ln_evidence());
    for model in &models {
        if model.evidence.is_none() {
            ui.say(format!("  no evidence     {}: {}", model.id, model.remark.as_deref().unwrap_or("")));
            continue;
        }
        ui.say(format!("  {:>9.1} nats  {}", model.ln_evidence() - best, model.id));
        for remark in crate::results::reasons(&model.remark) {
            ui.say(format!("                  {remark}"));
        }
    }
    if let [first, second, ..] = models[..]
        && first.ln_evidence() - second.ln_evidence() < stage.decides
    {
        ui.say(format!(
            "  not decided: {} and {} are less than {} nats apart",
            first.id, second.id, stage.decides
        ));
    } else if let [first, _, ..] = models[..]
        && first.too_sure
    {
        ui.say("  what the best model leaves is not noise: its lead is too sure");
    }
    if let Some(model) = models.first() {
        let (own, errors, channels) = model.by_kind();
        let told = errors.iter().filter(|p| !p.is_as_before());
        for p in own.iter().chain(told).chain(channels) {
            ui.say(format!("      {} = {}", p.name, number::quantity(p.value, p.sd, &p.unit)));
            warn_of_prior(ui, p);
        }
        let untold = errors.iter().filter(|p| p.is_as_before()).count();
        if untold > 0 {
            ui.say(format!(
                "      {untold} stated {} counted, of which these data tell nothing",
                if untold == 1 { "error is" } else { "errors are" }
            ));
        }
        for n in model.noise.iter().filter(|n| n.floats) {
            let unit = if n.unit == "1" { "" } else { &n.unit };
            ui.say(format!("      {}: {:.3e} {unit}", n.name, n.sd).trim_end());
        }
        ui.say(format!(
            "      residual {:.3e}, correlation of neighbours {:.2}",
            model.residual, model.neighbours
        ));
    }
}
