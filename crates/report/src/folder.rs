//! The page of a study from the numbers that its ranking kept.

use crate::response_study::{answers, response_page};
use crate::{StudyHead, StudyPage};
use rijke_engine::SavedModel;
use rijke_engine::folder::{ResponseResults, Results, kept, observations, open_study, rival_of};
use rijke_engine::run::{Sliders, StageRecord};
use rijke_numerics::{Classify, Failed, Lock, write_output};
use rijke_study::plan::Plan;
use rijke_study::{Claims, ObservedModes, Study};
use std::path::{Path, PathBuf};

/// Writes the page of the study in `dir`, which was ranked.
pub fn draw_study(dir: &Path) -> Result<PathBuf, Failed> {
    let study = open_study(dir)?;
    let results = dir.join("results");
    let mut found_beside = Vec::new();
    if !study.plan.responses.is_empty() {
        let (responses, within) = ResponseResults::read(&study)?;
        found_beside = answers(&responses.stages);
        let _lock = Lock::take(&results)?;
        write_response_page(&study.plan, &responses, &results.join(within))?;
    }
    if !study.plan.stages.is_empty() {
        let observations = observations(&study)?;
        let Results { stages, answers, verdicts } = Results::read(dir, &study.plan)?;
        let head = StudyHead { found_beside, ..StudyHead::of(&study, &observations) };
        let sliders = sliders(&study, &observations, &stages);
        let _lock = Lock::take(&results)?;
        let page = StudyPage::new(&head, &stages, &answers, &verdicts, sliders.as_ref())?;
        page.write(&results)?;
    }
    Ok(results.join("index.html"))
}

/// Writes the page of stages of responses with its figures.
pub fn write_response_page(plan: &Plan, found: &ResponseResults, folder: &Path) -> Result<(), Failed> {
    let head = StudyHead {
        name: plan.name.clone(),
        question: plan.question.clone(),
        kind: found.data.kind,
        source: found.data.source.clone(),
        claims: Claims::default(),
        factors: Vec::new(),
        beside: None,
        found_beside: Vec::new(),
    };
    for (name, content) in response_page(&head, &found.data.doubts, &found.stages)? {
        let path = folder.join(name);
        path.parent().map_or(Ok(()), std::fs::create_dir_all).or_failed().map_err(|f| f.at(&path))?;
        write_output(&path, &content)?;
    }
    Ok(())
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
