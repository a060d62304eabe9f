//! One task of a search: its name, the hash of all that it depends on, and where its result is kept.

use crate::EngineError;
use crate::rows::Choice;
use crate::run::course::{Run, Trusted};
use crate::run::points::inputs::selected;
use crate::run::record::EvidenceRecord;
use rijke_study::plan::Stage;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// What a task found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Outcome {
    pub(super) evidence: Option<EvidenceRecord>,
    /// Warnings, or why there is no evidence.
    pub(super) remark: Option<String>,
}

/// Hashes of what tasks depend on.
pub(super) struct Names {
    /// The rig, the stage and the data of its points, by stage.
    stages: Vec<String>,
    /// Candidates by id.
    candidates: BTreeMap<String, String>,
    trusted: Trusted,
}

impl Names {
    pub(super) fn of(run: &Run) -> Self {
        let study = &run.study;
        let rig = hash(&[&format!("{:?} {:?}", study.rig, run.channels)]);
        let stage = |stage: &Stage| {
            let points = selected(study, &run.observed, &stage.points);
            hash(&[env!("CARGO_PKG_VERSION"), &rig, &format!("{stage:?}"), &format!("{points:?}")])
        };
        let candidates = study.catalogue.candidates().iter();
        Self {
            stages: study.plan.stages.iter().map(stage).collect(),
            candidates: candidates.map(|c| (c.id.clone(), hash(&[&format!("{c:?}")]))).collect(),
            trusted: run.trusted,
        }
    }

    /// The task that trains `choice` at a stage on the model that the task `parent` left.
    pub(super) fn task(&self, level: usize, choice: &Choice, parent: &str, trusted: Trusted) -> String {
        let trusted = format!("{trusted:?}");
        let candidates = choice.values().filter_map(|id| self.candidates.get(id).map(String::as_str));
        hash(&[&[&*self.stages[level], parent, &*trusted][..], &candidates.collect::<Vec<_>>()].concat())
    }

    /// The task that finds the greedy choice.
    pub(super) fn greedy(&self) -> String {
        let trusted = format!("greedy {:?}", self.trusted);
        let texts = self.stages.iter().chain(self.candidates.values()).map(String::as_str);
        hash(&std::iter::once(&*trusted).chain(texts).collect::<Vec<_>>())
    }
}

/// Hash of texts; where one ends and the next begins counts.
pub(super) fn hash(texts: &[&str]) -> String {
    let mut hasher = Sha256::new();
    for text in texts {
        hasher.update((text.len() as u64).to_le_bytes());
        hasher.update(text);
    }
    format!("{:x}", hasher.finalize())
}

/// The folder in which results of tasks are kept, a file each; without one nothing is kept.
pub(super) struct Kept(pub(super) Option<PathBuf>);

impl Kept {
    /// A file that cannot be read is as one that is not there.
    pub(super) fn read<T: DeserializeOwned>(&self, task: &str) -> Option<T> {
        let path = self.0.as_ref()?.join(format!("{task}.json"));
        serde_json::from_str(&rijke_numerics::read_text(&path).ok()?).ok()
    }

    /// The file appears under its name only when it is complete. Who writes it second writes the same.
    pub(super) fn write(&self, task: &str, what: &impl Serialize) -> Result<(), EngineError> {
        let Some(folder) = &self.0 else { return Ok(()) };
        let path = folder.join(format!("{task}.json"));
        let fail = |problem: String| EngineError::File { file: path.display().to_string(), problem };
        let text = serde_json::to_string(what).map_err(|e| fail(e.to_string()))?;
        let written = std::fs::create_dir_all(folder)
            .and_then(|()| rijke_numerics::write_whole(&path, (text + "\n").as_bytes()));
        written.map_err(|e| fail(e.to_string()))
    }
}
