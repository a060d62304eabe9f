//! A study folder whose stages train on responses, run from its files to its page.

use crate::{
    failure::{Classify, Failure},
    staging::StagedFolder,
    ui::Ui,
};
use rijke_engine::EngineError;
use rijke_engine::response::{ResponseModelRecord, ResponseRun, ResponseStageRecord};
use rijke_report::{StudyHead, response_page};
use rijke_study::Study;
use serde_json::json;

/// Runs the stages of a study in order, and writes their numbers and the page into its folder `results`.
pub(crate) fn run(study: Study, force: bool, ui: &Ui) -> Result<(), Failure> {
    let dir = study.folder.clone();
    if !study.plan.stages.is_empty() {
        return Err(Failure::bad_input("study.toml has stages of modes and of responses")
            .at(&dir)
            .remedy("Put the stages of modes into a study folder of their own."));
    }
    let observed = study.responses().or_bad_input()?;
    for warning in &observed.warnings {
        ui.note(format!("warning: {warning}"));
    }
    let head = StudyHead {
        name: study.plan.name.clone(),
        question: study.plan.question.clone(),
        kind: observed.kind,
        source: observed.source.clone(),
        claims: rijke_study::Claims::default(),
        factors: Vec::new(),
    };
    let doubts = observed.warnings.clone();
    let results = dir.join("results");
    let staged = StagedFolder::new(&results, "index.html", force)?;
    let progress = ui.progress("stages", study.plan.responses.len() as u64);
    let mut run = ResponseRun::new(study, observed);
    let mut stages: Vec<ResponseStageRecord> = Vec::new();
    let fail = |error: &EngineError| match error {
        EngineError::Inference(_) | EngineError::Dense(_) => Failure::failed(error).at(&dir),
        _ => Failure::bad_input(error).at(&dir),
    };
    while let Some(stage) = run.next_stage().map_err(|e| fail(&e))? {
        progress.advance(1);
        stages.push(stage);
    }
    drop(progress);
    let numbers = staged.path().join("numbers");
    std::fs::create_dir_all(&numbers).or_failed().map_err(|f| f.at(&numbers))?;
    for stage in &stages {
        let path = numbers.join(format!("{}.json", stage.id));
        let text = serde_json::to_string(stage).or_failed()?;
        std::fs::write(&path, text + "\n").or_failed().map_err(|f| f.at(&path))?;
    }
    for (name, content) in response_page(&head, &doubts, &stages).or_failed()? {
        let path = staged.path().join(name);
        let folder = path.parent().map_or(Ok(()), std::fs::create_dir_all);
        folder.and_then(|()| std::fs::write(&path, content)).or_failed().map_err(|f| f.at(&path))?;
    }
    staged.commit()?;
    stages.iter().for_each(|stage| table(ui, stage));
    ui.result(&json!({ "page": results.join("index.html"), "stages": stages.iter().map(short).collect::<Vec<_>>() }))
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
    ui.say(format!("{} ({} responses, {count} complex numbers)", stage.title, stage.loads.len()));
    let mut models: Vec<&ResponseModelRecord> = stage.models.iter().collect();
    models.sort_by(|a, b| b.ln_evidence().total_cmp(&a.ln_evidence()));
    let best = models.first().map_or(0.0, |m| m.ln_evidence());
    for model in &models {
        if model.evidence.is_none() {
            ui.say(format!("  no evidence     {}: {}", model.id, model.remark.as_deref().unwrap_or("")));
            continue;
        }
        ui.say(format!("  {:>9.1} nats  {}", model.ln_evidence() - best, model.id));
        if let Some(remark) = &model.remark {
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
    }
    if let Some(model) = models.first() {
        for p in &model.parameters {
            ui.say(format!("      {} = {:.6e} +- {:.2e} {}", p.name, p.value, p.sd, p.unit));
        }
        for n in model.noise.iter().filter(|n| n.floats) {
            ui.say(format!("      {}: {:.3e} {}", n.name, n.sd, n.unit));
        }
        ui.say(format!(
            "      residual {:.3e}, correlation of neighbours {:.2}",
            model.residual, model.neighbours
        ));
    }
}
