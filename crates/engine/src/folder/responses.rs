//! Stages of a study folder that train on responses: trained in order, their numbers kept.

use super::results::{keep, kept};
use super::study::doubts_of;
use crate::EngineError;
use crate::response::{Ground, ResponseModelRecord, ResponseRun, ResponseStageRecord};
use crate::run::Trusted;
use crate::told::tell_responses;
use rijke_numerics::{Classify, Failed, Tell, write_within};
use rijke_rig::DataKind;
use rijke_study::Study;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::path::Path;

/// What the page says of the data, kept beside the numbers so that it can be drawn again.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ResponseData {
    /// Measured or virtual.
    pub kind: DataKind,
    /// Where they come from.
    pub source: String,
    /// What is doubtful about them.
    pub doubts: Vec<String>,
}

/// The file of it, within the results.
const DATA: &str = "data";

/// All stages of responses of a study.
#[derive(Clone, Debug)]
pub struct ResponseResults {
    /// Of what they are.
    pub data: ResponseData,
    /// By stage.
    pub stages: Vec<ResponseStageRecord>,
}

impl ResponseResults {
    /// Where they are within the results of a study that has stages of modes as well.
    pub const BESIDE_MODES: &'static str = "responses";

    /// Reads those that ranking kept, and says in which folder of the results of the study they are.
    pub fn read(study: &Study) -> Result<(Self, &'static str), Failed> {
        let beside = if study.plan.stages.is_empty() { "" } else { Self::BESIDE_MODES };
        let (dir, within) = (&study.folder, Path::new(beside));
        let numbers = within.join("numbers").display().to_string();
        let stages = study.plan.responses.iter().map(|s| s.id.as_str());
        let there = |id: &&str| dir.join("results").join(&numbers).join(format!("{id}.json")).is_file();
        let stages = stages.filter(there).map(|id| kept(dir, &numbers, id)).collect::<Result<_, _>>()?;
        Ok((Self { data: kept(dir, beside, DATA)?, stages }, beside))
    }

    /// Every stage without its curves.
    pub fn shorts(&self) -> Vec<serde_json::Value> {
        self.stages.iter().map(short).collect()
    }
}

/// Trains the stages of responses of a study in order; their numbers go into `folder`. Also what stages of
/// modes take of them.
///
/// # Errors
/// File, place and remedy, or a search that does not end.
pub fn rank_responses(
    mut study: Study,
    trusted: Trusted,
    folder: &Path,
    tell: &dyn Tell,
) -> Result<(ResponseResults, Vec<Ground>), Failed> {
    let dir = study.folder.clone();
    if trusted == Trusted::Laplace {
        study.plan.responses.iter_mut().for_each(|stage| stage.checked = false);
    }
    let observed = study.responses().or_bad_input()?;
    if study.plan.stages.is_empty() {
        tell.warn(&study.unused());
        tell.warn(&doubts_of(&study));
    }
    tell.warn(&observed.warnings);
    let doubts = doubts_of(&study).into_iter().chain(observed.warnings.iter().cloned()).collect();
    let data = ResponseData { kind: observed.kind, source: observed.source.clone(), doubts };
    let mut run = ResponseRun::new(study, observed).map_err(|e| response_fault(&e, &dir))?;
    let progress = tell.progress("models", run.models_of_all() as u64);
    let mut stages: Vec<ResponseStageRecord> = Vec::new();
    while let Some(stage) = run.next_stage_with(&|| progress(1)).map_err(|e| response_fault(&e, &dir))? {
        stages.push(stage);
    }
    drop(progress);
    let line = |what: serde_json::Result<String>| Ok::<_, Failed>(what.or_failed()? + "\n");
    write_within(folder, &format!("{DATA}.json"), line(serde_json::to_string(&data))?)?;
    for stage in &stages {
        write_within(folder, &format!("numbers/{}.json", stage.id), line(serde_json::to_string(stage))?)?;
    }
    let grounds = run.grounds();
    for ground in &grounds {
        keep(&folder.join("models"), &ground.id, ground)?;
    }
    stages.iter().for_each(|stage| tell_responses(stage, tell));
    Ok((ResponseResults { data, stages }, grounds))
}

/// What is wrong with a study of responses, and who must act.
pub(super) fn response_fault(error: &EngineError, dir: &Path) -> Failed {
    match error {
        EngineError::Inference(_) | EngineError::Dense(_) => Failed::of_work(error).at(dir),
        EngineError::Refused { .. } | EngineError::NoPoint { .. } | EngineError::NothingSelected { .. } => {
            Failed::bad_input(error).at(&dir.join("study.toml"))
        }
        EngineError::NoWinner { .. } => Failed::bad_input(error).at(dir).remedy(
            "If that does not help: check signs, units and reference of the data with `rijke check`, and the priors; a noise that is stated too \
             small makes every model impossible: let it be inferred.",
        ),
        _ => Failed::bad_input(error).at(dir),
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
