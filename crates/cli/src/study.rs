//! A study folder, run from its files to its page.

use crate::{
    failure::{Classify, Failure},
    staging::StagedFolder,
    ui::Ui,
};
use rijke_engine::EngineError;
use rijke_engine::run::{Run, StageRecord, Trusted};
use rijke_report::{StudyHead, StudyPage};
use rijke_study::{Study, StudyError};
use serde_json::json;
use std::path::Path;

/// Whether a folder is that of a study.
pub(crate) fn is_study(dir: &Path) -> bool {
    dir.join("study.toml").is_file()
}

/// Reads a study, runs its stages in order, and writes their numbers and the page into DIR/results.
pub(crate) fn run(dir: &Path, force: bool, trusted: Trusted, ui: &Ui) -> Result<(), Failure> {
    let study = Study::open(dir).map_err(|e| bad(&e))?;
    if !study.plan.responses.is_empty() {
        return crate::study_responses::run(study, force, ui);
    }
    let observations = study.observations().map_err(|e| {
        bad(&e).remedy("Give observations/modes.csv and observations/observations.toml; docs/study-folder.md describes both.")
    })?;
    let factor = |f: &rijke_study::Factor| (f.name.clone(), f.unit.clone());
    let head = StudyHead {
        name: study.plan.name.clone(),
        question: study.plan.question.clone(),
        kind: observations.kind,
        source: observations.source.clone(),
        factors: study.campaign.factors.iter().map(factor).collect(),
    };
    let results = dir.join("results");
    let staged = StagedFolder::new(&results, "index.html", force)?;
    let progress = ui.progress("stages", study.plan.stages.len() as u64);
    let mut run = Run::new(study, &observations, trusted).map_err(|e| of_the_engine(&e, dir))?;
    let mut stages: Vec<StageRecord> = Vec::new();
    while let Some(stage) = run.next_stage().map_err(|e| of_the_engine(&e, dir))? {
        progress.advance(1);
        stages.push(stage);
    }
    drop(progress);
    let numbers = staged.path().join("numbers");
    std::fs::create_dir_all(&numbers).or_failed().map_err(|f| f.at(&numbers))?;
    for stage in &stages {
        let path = numbers.join(format!("{}.json", stage.id));
        let text = serde_json::to_string_pretty(stage).or_failed()?;
        std::fs::write(&path, text + "\n").or_failed().map_err(|f| f.at(&path))?;
    }
    StudyPage::new(&head, &stages).or_failed()?.write(staged.path()).or_failed()?;
    staged.commit()?;
    stages.iter().for_each(|stage| table(ui, stage));
    ui.result(&json!({ "page": results.join("index.html"), "stages": stages }))
}

/// The models of a stage, best first.
fn table(ui: &Ui, stage: &StageRecord) {
    ui.say(format!("{} ({} modes)", stage.title, stage.measured.len()));
    let total = |m: &rijke_engine::run::ModelRecord| m.evidence.map_or(f64::NEG_INFINITY, |e| e.ln_marginal);
    let mut models: Vec<_> = stage.models.iter().collect();
    models.sort_by(|a, b| total(b).total_cmp(&total(a)));
    let best = models.first().map_or(0.0, |m| total(m));
    for model in models {
        let mark = if model.id == stage.chosen { "  <- goes on" } else { "" };
        match model.evidence {
            Some(_) => {
                ui.say(format!("  {:>9.1} nats  {}{mark}", total(model) - best, model.id));
                if let Some(remark) = &model.remark {
                    ui.say(format!("                  {remark}"));
                }
            }
            None => {
                ui.say(format!("  no evidence     {}: {}", model.id, model.remark.as_deref().unwrap_or("")))
            }
        }
    }
    if let Some(model) = stage.models.iter().find(|m| m.id == stage.chosen) {
        for p in &model.parameters {
            ui.say(format!("      {} = {:.6} +- {:.2e} {}", p.name, p.value, p.sd, p.unit));
            if let Some(z) = p.prior_sds.filter(|z| z.abs() > 4.0) {
                ui.note(format!(
                    "warning: {} lies {:.1} sd of its prior from what was known before: prior and data contradict each other, or the model is wrong",
                    p.name,
                    z.abs()
                ));
            }
        }
    }
}

fn bad(error: &StudyError) -> Failure {
    Failure::bad_input(error)
}

/// What the files say can be wrong in ways that are seen only when a model is built from them.
fn of_the_engine(error: &EngineError, dir: &Path) -> Failure {
    match error {
        EngineError::NotConverged { .. } | EngineError::Inference(_) | EngineError::Dense(_) => {
            Failure::failed(error).at(dir)
        }
        _ => Failure::bad_input(error).at(dir),
    }
}
