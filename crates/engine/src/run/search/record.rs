//! What a search finds, as it is written.

use crate::run::record::EvidenceRecord;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What one shard of a search found, or all of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SearchPart {
    /// Hash of all that the search depends on: parts of one search have the same.
    pub search: String,
    /// What the study is called.
    pub study: String,
    /// The stages, each of which stands on earlier ones.
    pub stages: Vec<String>,
    /// How many nats a model may trail the greedy choice; none for a search of every combination.
    pub within: Option<f64>,
    /// Which shard of how many, counted from 1.
    pub shard: [usize; 2],
    /// Combinations in all shards.
    pub combinations: usize,
    /// Models of single stages in all shards.
    pub models: usize,
    /// The nodes of the greedy choice, by level.
    pub greedy: Vec<usize>,
    /// The models that the shard visited, in order.
    pub nodes: Vec<SearchNode>,
}

/// A model of one stage on models of the stages before it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SearchNode {
    /// Its stage.
    pub level: usize,
    /// Its place among all of that stage.
    pub node: usize,
    /// The place of the model of the stage before.
    pub parent: usize,
    /// How many combinations hold it.
    pub combinations: usize,
    /// Role and candidate.
    pub candidates: BTreeMap<String, String>,
    /// The task that trained it: a hash of all that it depends on.
    pub task: String,
    /// Evidence of the stage's data given those of the stages before; none if it could not be fitted.
    pub evidence: Option<EvidenceRecord>,
    /// Warnings, or why there is no evidence.
    pub remark: Option<String>,
    /// Whether it trails the greedy choice too far for all that stands on it to be trained.
    pub given_up: bool,
    /// The place, in the last stage, of the combination that continues it with the later candidates of the
    /// greedy choice.
    pub continued: usize,
}

/// What a whole search found. All candidates of a role are equally probable before the data, and so are all
/// combinations.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SearchRecord {
    /// What the study is called.
    pub study: String,
    /// The stages, each of which stands on earlier ones.
    pub stages: Vec<String>,
    /// How many nats a model may trail the greedy choice; none for a search of every combination.
    pub within: Option<f64>,
    /// Combinations that the study allows.
    pub combinations: usize,
    /// Models of single stages that these consist of.
    pub models: usize,
    /// How many of these were trained.
    pub models_trained: usize,
    /// Combinations trained to the last stage, most probable first.
    pub best: Vec<Combination>,
    /// Probability of each candidate of each role of which combinations have different ones.
    pub choices: Vec<RoleChoice>,
    /// What ranking stage by stage chose.
    pub greedy: GreedyChoice,
    /// For each stage, the most that a model of it gained, of those that were followed, when it was continued
    /// otherwise than with the later candidates of the greedy choice, nats.
    pub gained: Vec<f64>,
    /// What was not followed to the last stage, but for one combination each, because it trails the greedy
    /// choice.
    pub given_up: Vec<GivenUp>,
    /// The most probability that all of it can hold, if no model that was given up gains more than `gained`.
    /// Probabilities above leave it out.
    pub given_up_at_most: f64,
    /// What could not be fitted, and holds no probability here.
    pub not_fitted: Vec<GivenUp>,
}

/// A combination of candidates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Combination {
    /// Role and candidate, over all stages.
    pub candidates: BTreeMap<String, String>,
    /// ln evidence of all data, nats.
    pub ln_evidence: f64,
    /// That of each stage, given the ones before.
    pub stages: Vec<f64>,
    /// Probability among the combinations that were trained.
    pub probability: f64,
    /// Warnings of its stages.
    pub remark: Option<String>,
}

/// The candidates of one role.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RoleChoice {
    /// The role.
    pub role: String,
    /// Candidate, and the probability of all combinations that hold it; without a name, of those that have
    /// none.
    pub candidates: Vec<(String, f64)>,
}

/// What ranking stage by stage chose, among all.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GreedyChoice {
    /// Role and candidate, over all stages.
    pub candidates: BTreeMap<String, String>,
    /// Its place in the order of evidence, from 1; none if it could not be fitted.
    pub rank: Option<usize>,
    /// Its probability.
    pub probability: f64,
    /// Nats by which it trails the best; none if it could not be fitted.
    pub behind: Option<f64>,
}

/// A model with all combinations that hold it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GivenUp {
    /// The stage after which it was left.
    pub stage: String,
    /// Role and candidate up to there.
    pub candidates: BTreeMap<String, String>,
    /// How many combinations hold it that were not trained to the end.
    pub combinations: usize,
    /// ln evidence up to there.
    pub ln_evidence: Option<f64>,
    /// The most probability that it can hold; see [`SearchRecord::given_up_at_most`].
    pub at_most: f64,
    /// Warnings, or why it could not be fitted.
    pub remark: Option<String>,
}
