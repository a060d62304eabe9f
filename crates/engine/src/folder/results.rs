//! `DIR/results`: what ranking keeps of each stage, by file, and what later steps read of it.

use super::study::{observations, open_study, warn_of_study};
use crate::SavedModel;
use crate::run::{Answer, Judgement, OpenModel, StageRecord};
use rijke_numerics::{Classify, Failed, Tell, write_within};
use rijke_study::plan::{Plan, Stage};
use rijke_study::{ObservedModes, Study};
use serde::{Serialize, de::DeserializeOwned};
use std::path::Path;

/// A stage that the study does not have.
pub(super) fn no_stage(id: &str, plan: &Plan, dir: &Path) -> Failed {
    none_of(id, &plan.stages.iter().map(|s| s.id.as_str()).collect::<Vec<_>>(), dir)
}

/// The place of a stage among all.
pub fn known_stage(id: &str, all: &[&str], dir: &Path) -> Result<usize, Failed> {
    all.iter().position(|known| *known == id).ok_or_else(|| none_of(id, all, dir))
}

/// A stage of a study with what was observed and the model that ranking kept of it.
pub struct Ranked {
    /// The study.
    pub study: Study,
    /// What was observed.
    pub observed: ObservedModes,
    /// The stage.
    pub stage: Stage,
    /// Places in the campaign of the points of the stage.
    pub every: Vec<usize>,
    /// The model that goes on.
    pub model: SavedModel,
}

impl Ranked {
    /// Reads them; without a name, of the last stage.
    pub fn open(dir: &Path, stage: Option<&str>, tell: &dyn Tell) -> Result<Self, Failed> {
        let study = open_study(dir)?;
        warn_of_study(dir, tell);
        let observed = observations(&study)?;
        let named =
            |id: &str| study.plan.stage(id).map(|(_, s)| s).ok_or_else(|| no_stage(id, &study.plan, dir));
        let last = || study.plan.stages.last().ok_or_else(|| no_stage("", &study.plan, dir));
        let stage = stage.map_or_else(last, named)?.clone();
        let every = stage.points.places(&study.campaign);
        let model = kept(dir, "models", &stage.id)?;
        Ok(Self { study, observed, stage, every, model })
    }

    /// The models that are open beside the one that goes on; none where the evidence decides.
    pub fn open_models(&self) -> Result<Vec<OpenModel>, Failed> {
        Ok(kept_if_any(&self.study.folder, &open_of(&self.stage.id))?.unwrap_or_default())
    }

    /// The open models or, where nothing is open, the best other model; a stage of one model has none.
    pub fn rivals(&self) -> Result<Vec<OpenModel>, Failed> {
        let mut rivals = self.open_models()?;
        if rivals.is_empty() {
            let rival: Option<SavedModel> = kept_if_any(&self.study.folder, &rival_of(&self.stage.id))?;
            rivals.extend(rival.map(|model| OpenModel { odds: 0.0, model }));
        }
        Ok(rivals)
    }
}

fn none_of(id: &str, all: &[&str], dir: &Path) -> Failed {
    Failed::bad_input(format!("there is no stage called `{id}`"))
        .at(&dir.join("study.toml"))
        .remedy(format!("Give one of: {}.", all.join(", ")))
}

/// One file of DIR/results/models that need not be there.
pub(super) fn kept_if_any<T: DeserializeOwned>(dir: &Path, name: &str) -> Result<Option<T>, Failed> {
    let there = dir.join("results/models").join(format!("{name}.json")).is_file();
    there.then(|| kept(dir, "models", name)).transpose()
}

/// One file of DIR/results.
pub fn kept<T: DeserializeOwned>(dir: &Path, folder: &str, name: &str) -> Result<T, Failed> {
    let path = dir.join("results").join(folder).join(format!("{name}.json"));
    let remedy = rank_first(dir);
    let text = rijke_numerics::read_text(&path).or_bad_input().map_err(|f| f.at(&path).remedy(&remedy))?;
    serde_json::from_str(&text).or_bad_input().map_err(|f| f.at(&path).remedy(&remedy))
}

/// What to do where results are missing or damaged.
pub(crate) fn rank_first(dir: &Path) -> String {
    format!("Run `rijke rank {}` first, again if the study has changed.", dir.display())
}

/// Says again what speaks against a stage by its ranking, beside numbers that take its model for right.
pub fn warn_of_ranking(dir: &Path, stage: &str, tell: &dyn Tell) {
    // Results of an older version may lack the file.
    let Ok(record) = kept::<StageRecord>(dir, "numbers", &format!("stage-{stage}")) else { return };
    let chosen = record.models.iter().find(|m| m.id == record.chosen);
    // Of further maxima the predictions say more.
    let remarks = chosen.iter().flat_map(|m| m.remarks()).filter(|said| !said.contains("further maxim"));
    remarks.for_each(|said| said_by_rank(said, tell));
    record.doubts_of_data().iter().for_each(|said| said_by_rank(said, tell));
    if let Some(family) = record.missing.as_ref().and_then(|missing| missing.required().next()) {
        tell.note(format!(
            "warning: `rijke rank` found that the data require a further term in this model ({}); these predictions assume a complete model, and their standard deviations are too small",
            family.first.words()
        ));
    }
}

/// Repeats what the ranking said of a model.
pub(super) fn said_by_rank(said: &str, tell: &dyn Tell) {
    tell.note(format!("warning: `rijke rank` said of this model: {said}"));
}

/// Where the best model of a stage but the one that goes on is kept.
pub fn rival_of(stage: &str) -> String {
    format!("{stage}.rival")
}

/// Where the models are kept that are open beside the one that goes on from a stage.
pub(super) fn open_of(stage: &str) -> String {
    format!("{stage}.open")
}

/// Writes one file of results as JSON.
pub(super) fn keep(folder: &Path, name: &str, what: &impl Serialize) -> Result<(), Failed> {
    let text = serde_json::to_string_pretty(what).or_failed()?;
    write_within(folder, &format!("{name}.json"), text + "\n")
}

/// Everything that ranking finds.
pub struct Results {
    /// By stage.
    pub stages: Vec<StageRecord>,
    /// To questions and maps; an overview of each stage.
    pub answers: Vec<Answer>,
    /// On what others published.
    pub verdicts: Vec<Judgement>,
}

impl Results {
    /// Reads what ranking wrote for a study, up to the stage after which it stopped.
    pub fn read(dir: &Path, plan: &Plan) -> Result<Self, Failed> {
        let verdicts = kept(dir, "numbers", "claims")?;
        let numbers = dir.join("results/numbers");
        let there = |name: &String| numbers.join(format!("{name}.json")).is_file();
        let stages = plan.stages.iter().map(|s| format!("stage-{}", s.id)).filter(there);
        let answers = plan.answers().map(|id| format!("answer-{id}")).filter(there);
        let whole = |name: String| {
            let answer: Answer = kept(dir, "numbers", &name)?;
            for frame in &answer.frames {
                let count = frame.columns.len();
                if let Some(row) = frame.rows.iter().find(|row| row.values.len() > count) {
                    let what =
                        format!("row `{}` has {} values for {count} columns", row.label, row.values.len());
                    let file = numbers.join(format!("{name}.json"));
                    return Err(Failed::bad_input(what).at(&file).remedy(rank_first(dir)));
                }
            }
            Ok(answer)
        };
        Ok(Self {
            stages: stages.map(|name| kept(dir, "numbers", &name)).collect::<Result<_, _>>()?,
            answers: answers.map(whole).collect::<Result<_, _>>()?,
            verdicts,
        })
    }
}
