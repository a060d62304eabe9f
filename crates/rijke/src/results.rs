//! What the rankings of studies of modes and of responses share: options, stages by name, files of results,
//! warnings.

use crate::{
    failure::{Classify, Failure},
    number,
    study::{observations, open, warn_of_study},
    ui::Ui,
};
use rijke_engine::SavedModel;
use rijke_engine::run::{Missing, StageRecord, TrainedParameter, Trusted};
use rijke_inference::SamplerKind;
use rijke_study::plan::Stage;
use rijke_study::{ObservedModes, Study};
use serde::de::DeserializeOwned;
use std::path::Path;

/// How far evidences are checked.
#[derive(Clone, Copy, clap::Args)]
pub(crate) struct Trust {
    /// Search one maximum of each posterior only, and check nothing: faster, and wrong where there are
    /// several.
    #[arg(long, conflicts_with = "sampler")]
    one_start: bool,
    /// Compare every evidence with a slow method that needs no Gaussian approximation.
    #[arg(long, value_name = "METHOD")]
    sampler: Option<Sampler>,
    /// Statistical error of the sampler, nats; its cost grows with the inverse square.
    #[arg(long, value_name = "NATS", default_value_t = 0.3, value_parser = number::positive)]
    sampler_error: f64,
}

/// Slow methods of evidence.
#[derive(Clone, Copy, clap::ValueEnum)]
enum Sampler {
    /// Nested sampling.
    Nested,
    /// The gradient sampler NUTS with bridge sampling; only if the program was built with the feature `nuts`.
    Nuts,
}

impl Trust {
    pub(crate) fn has_sampler(self) -> bool {
        self.sampler.is_some()
    }

    pub(crate) fn is_one_start(self) -> bool {
        self.one_start
    }

    pub(crate) fn trusted(self) -> Result<Trusted, Failure> {
        let kind = match self.sampler {
            Some(Sampler::Nested) => SamplerKind::Nested,
            Some(Sampler::Nuts) if cfg!(feature = "nuts") => SamplerKind::Nuts,
            Some(Sampler::Nuts) => {
                return Err(Failure::bad_input("--sampler nuts: this program was built without NUTS")
                    .remedy("Build it with `cargo install --path crates/rijke --features nuts`, or use --sampler nested."));
            }
            None if self.one_start => return Ok(Trusted::Laplace),
            None => return Ok(Trusted::Checked),
        };
        Ok(Trusted::Sampled(kind, self.sampler_error))
    }
}

/// A stage that the study does not have.
pub(crate) fn no_stage(id: &str, plan: &rijke_study::plan::Plan, dir: &Path) -> Failure {
    none_of(id, &plan.stages.iter().map(|s| s.id.as_str()).collect::<Vec<_>>(), dir)
}

/// The place of a stage among all.
pub(crate) fn known_stage(id: &str, all: &[&str], dir: &Path) -> Result<usize, Failure> {
    all.iter().position(|known| *known == id).ok_or_else(|| none_of(id, all, dir))
}

/// A stage of a study with what was observed and the model that ranking kept of it.
pub(crate) struct Ranked {
    pub(crate) study: Study,
    pub(crate) observed: ObservedModes,
    pub(crate) stage: Stage,
    /// Places in the campaign of the points of the stage.
    pub(crate) every: Vec<usize>,
    pub(crate) model: SavedModel,
}

impl Ranked {
    /// Reads them; without a name, of the last stage.
    pub(crate) fn open(dir: &Path, stage: Option<&str>, ui: &Ui) -> Result<Self, Failure> {
        let study = open(dir)?;
        warn_of_study(dir, ui);
        let observed = observations(&study)?;
        let named =
            |id: &str| study.plan.stage(id).map(|(_, s)| s).ok_or_else(|| no_stage(id, &study.plan, dir));
        let last = || study.plan.stages.last().ok_or_else(|| no_stage("", &study.plan, dir));
        let stage = stage.map_or_else(last, named)?.clone();
        let points = &study.campaign.points;
        let every = (0..points.len()).filter(|k| stage.points.holds(&study.campaign, &points[*k])).collect();
        let model = kept(dir, "models", &stage.id)?;
        Ok(Self { study, observed, stage, every, model })
    }
}

fn none_of(id: &str, all: &[&str], dir: &Path) -> Failure {
    Failure::bad_input(format!("there is no stage called `{id}`"))
        .at(&dir.join("study.toml"))
        .remedy(format!("Give one of: {}.", all.join(", ")))
}

/// One file of DIR/results/models that need not be there.
pub(crate) fn kept_if_any<T: DeserializeOwned>(dir: &Path, name: &str) -> Result<Option<T>, Failure> {
    let there = dir.join("results/models").join(format!("{name}.json")).is_file();
    there.then(|| kept(dir, "models", name)).transpose()
}

/// One file of DIR/results.
pub(crate) fn kept<T: DeserializeOwned>(dir: &Path, folder: &str, name: &str) -> Result<T, Failure> {
    let path = dir.join("results").join(folder).join(format!("{name}.json"));
    let remedy = rank_first(dir);
    let text = rijke_numerics::read_text(&path).or_bad_input().map_err(|f| f.at(&path).remedy(&remedy))?;
    serde_json::from_str(&text).or_bad_input().map_err(|f| f.at(&path).remedy(&remedy))
}

/// What to do where results are missing or damaged.
pub(crate) fn rank_first(dir: &Path) -> String {
    format!("Run `rijke rank {}` first, again if the study has changed.", dir.display())
}

/// The reasons of a remark, which has a line for each.
pub(crate) fn reasons(remark: &Option<String>) -> impl Iterator<Item = &str> {
    remark.iter().flat_map(|remark| remark.lines())
}

/// Says again what a stage lacks by its ranking, beside numbers that take its model for complete.
pub(crate) fn warn_of_missing(dir: &Path, stage: &str, ui: &Ui) {
    // Results of an older version may lack the file.
    let Ok(record) = kept::<StageRecord>(dir, "numbers", &format!("stage-{stage}")) else { return };
    let first = record.missing.as_ref().and_then(|missing| missing.families.first());
    if let Some(family) = first.filter(|f| f.first.probability <= Missing::CHANCE) {
        ui.note(format!(
            "warning: by `rijke rank` something is missing in this model, described by {}: what is stated here takes it for complete",
            family.first.words()
        ));
    }
}

/// Says of a parameter that the data tell next to nothing of it.
pub(crate) fn not_identified(ui: &Ui, p: &TrainedParameter) {
    if p.is_as_before() {
        ui.say(format!("          not identified by these data: {} is as its prior", p.name));
    }
}

/// Warns of a parameter that lies far from its prior.
pub(crate) fn warn_of_prior(ui: &Ui, p: &TrainedParameter) {
    if let Some(z) = p.conflict() {
        ui.note(format!(
            "warning: {} lies {z:.1} sd of its prior from what was known before: prior and data contradict each other, or the model is wrong",
            p.name
        ));
    }
}
