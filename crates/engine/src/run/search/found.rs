//! What shards found, joined: probabilities of combinations, of each choice, and of what was given up.

use crate::EngineError;
use crate::run::record::EvidenceRecord;
use crate::run::rows::Choice;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

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
    /// Whether it trails the greedy choice too far for what stands on it to be trained.
    pub given_up: bool,
}

/// What a whole search found. All candidates of a role are equally probable before the data, and so are all combinations.
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
    /// Least and most that the stages after each added to a combination that was trained to the end, nats.
    pub later: Vec<[f64; 2]>,
    /// What was not followed to the last stage because it trails the greedy choice.
    pub given_up: Vec<GivenUp>,
    /// The most probability that all of it can hold, if no model that was given up gains more from later stages than the one that gained
    /// most of those that were followed. Probabilities above leave it out.
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
    /// Candidate, and the probability of all combinations that hold it; without a name, of those that have none.
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
    /// How many combinations hold it.
    pub combinations: usize,
    /// ln evidence up to there.
    pub ln_evidence: Option<f64>,
    /// The most probability that it can hold; see [`SearchRecord::given_up_at_most`].
    pub at_most: f64,
    /// Warnings, or why it could not be fitted.
    pub remark: Option<String>,
}

/// The nodes of a whole search.
struct Whole<'a> {
    first: &'a SearchPart,
    nodes: BTreeMap<(usize, usize), &'a SearchNode>,
}

/// Joins the parts of a search, in any order; a part that comes twice counts once.
///
/// # Errors
/// [`EngineError::Refused`] for parts of different searches, or that leave something out.
pub fn merge_searches(parts: &[SearchPart]) -> Result<SearchRecord, EngineError> {
    let refuse = |problem: String| {
        let stage = parts.first().and_then(|p| p.stages.last()).cloned().unwrap_or_default();
        Err(EngineError::Refused { stage, problem })
    };
    let Some(first) = parts.first() else { return refuse("there is no part of a search to join".to_owned()) };
    let mut nodes: BTreeMap<(usize, usize), &SearchNode> = BTreeMap::new();
    for part in parts {
        let same = |p: &SearchPart| (p.search.clone(), p.greedy.clone());
        if same(part) != same(first) {
            let [k, n] = part.shard;
            return refuse(format!(
                "shard {k} of {n} is of another search: study, options or greedy choice differ; make all parts of the same files with the same options"
            ));
        }
        for node in &part.nodes {
            if nodes.insert((node.level, node.node), node).is_some_and(|other| other != node) {
                let [k, n] = part.shard;
                return refuse(format!(
                    "shard {k} of {n} has another number for {} than a part before it; make all parts with one program on one kind of processor",
                    node.candidates.values().cloned().collect::<Vec<_>>().join(" + ")
                ));
            }
        }
    }
    let whole = Whole { first, nodes };
    let reached = whole.ends().map(|node| node.combinations).sum::<usize>();
    if reached != first.combinations {
        let n = first.shard[1];
        let there: BTreeSet<usize> = parts.iter().filter(|p| p.shard[1] == n).map(|p| p.shard[0]).collect();
        let missing: Vec<String> = (1..=n).filter(|k| !there.contains(k)).map(|k| k.to_string()).collect();
        return refuse(format!(
            "the parts hold {reached} of {} combinations; make shard {} of {n} too",
            first.combinations,
            missing.join(", ")
        ));
    }
    if !whole.ends().any(|node| node.level + 1 == first.stages.len() && node.evidence.is_some()) {
        let why = whole.ends().filter_map(|node| node.remark.clone()).next().unwrap_or_default();
        return refuse(format!("no combination could be trained to the last stage; {why}"));
    }
    Ok(whole.record())
}

impl<'a> Whole<'a> {
    fn is_end(&self, node: &SearchNode) -> bool {
        node.level + 1 == self.first.stages.len() || node.given_up || node.evidence.is_none()
    }

    /// The nodes on which nothing was trained.
    fn ends(&self) -> impl Iterator<Item = &'a SearchNode> {
        self.nodes.values().copied().filter(|node| self.is_end(node))
    }

    /// A node with those before it, the first stage first.
    fn path(&self, node: &'a SearchNode) -> Vec<&'a SearchNode> {
        let mut path = vec![node];
        let mut at = node;
        while let Some(before) = at.level.checked_sub(1).and_then(|l| self.nodes.get(&(l, at.parent))) {
            path.push(before);
            at = before;
        }
        path.reverse();
        path
    }

    fn record(&self) -> SearchRecord {
        let SearchPart { study, stages, within, combinations, models, greedy, .. } = self.first.clone();
        let last = stages.len() - 1;
        let mut best: Vec<(usize, Combination)> = self
            .ends()
            .filter(|node| node.level == last && node.evidence.is_some())
            .map(|node| (node.node, combination(&self.path(node))))
            .collect();
        best.sort_by(|(a, one), (b, two)| two.ln_evidence.total_cmp(&one.ln_evidence).then(a.cmp(b)));
        let most = best.first().map_or(f64::NEG_INFINITY, |(_, c)| c.ln_evidence);
        let sum: f64 = best.iter().map(|(_, c)| (c.ln_evidence - most).exp()).sum();
        best.iter_mut().for_each(|(_, c)| c.probability = (c.ln_evidence - most).exp() / sum);
        let after = |c: &Combination, level: usize| c.stages[level + 1..].iter().sum::<f64>();
        let later: Vec<[f64; 2]> = (0..=last)
            .map(|level| {
                let all = || best.iter().map(|(_, c)| after(c, level));
                [all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max)]
            })
            .collect();
        let left = |node: &'a SearchNode| {
            let Combination { candidates, ln_evidence, remark, .. } = combination(&self.path(node));
            let ln_evidence = node.evidence.map(|_| ln_evidence);
            let weight = ln_evidence.map_or(0.0, |ln| (ln + later[node.level][1] - most).exp());
            let weight = weight * node.combinations as f64;
            let stage = stages[node.level].clone();
            (
                weight,
                GivenUp {
                    stage,
                    candidates,
                    combinations: node.combinations,
                    ln_evidence,
                    at_most: 0.0,
                    remark,
                },
            )
        };
        let (mut given_up, mut not_fitted) = (Vec::new(), Vec::new());
        for node in self.ends() {
            if node.evidence.is_none() {
                not_fitted.push(left(node).1);
            } else if node.given_up {
                given_up.push(left(node));
            }
        }
        let outside: f64 = given_up.iter().map(|(weight, _)| weight).sum();
        let share = |weight: f64| weight / (sum + outside);
        let given_up: Vec<GivenUp> =
            given_up.into_iter().map(|(weight, g)| GivenUp { at_most: share(weight), ..g }).collect();
        let rank = best.iter().position(|(node, _)| *node == greedy[last]);
        let nodes = greedy.iter().enumerate().filter_map(|(level, k)| self.nodes.get(&(level, *k)).copied());
        let at_rank = rank.map(|k| &best[k].1);
        let greedy = GreedyChoice {
            candidates: combination(&nodes.collect::<Vec<_>>()).candidates,
            rank: rank.map(|k| k + 1),
            probability: at_rank.map_or(0.0, |c| c.probability),
            behind: at_rank.map(|c| most - c.ln_evidence),
        };
        let best: Vec<Combination> = best.into_iter().map(|(_, c)| c).collect();
        SearchRecord {
            choices: self.choices(&best),
            given_up_at_most: share(outside),
            study,
            stages,
            within,
            combinations,
            models,
            models_trained: self.nodes.len(),
            best,
            greedy,
            later,
            given_up,
            not_fitted,
        }
    }

    /// Roles of which combinations have different candidates, with their probabilities.
    fn choices(&self, best: &[Combination]) -> Vec<RoleChoice> {
        let mut roles: BTreeMap<String, BTreeMap<String, f64>> = BTreeMap::new();
        let all: Vec<Choice> = self.ends().map(|node| combination(&self.path(node)).candidates).collect();
        for choice in &all {
            for (role, id) in choice {
                roles.entry(role.clone()).or_default().entry(id.clone()).or_insert(0.0);
            }
        }
        for (role, candidates) in &mut roles {
            // What was left after an early stage may yet have got one.
            if all.iter().any(|choice| !choice.contains_key(role))
                && best.iter().any(|c| !c.candidates.contains_key(role))
            {
                candidates.insert(String::new(), 0.0);
            }
            for c in best {
                let id = c.candidates.get(role).map_or("", String::as_str);
                candidates.entry(id.to_owned()).and_modify(|p| *p += c.probability);
            }
        }
        let record = |(role, candidates): (String, BTreeMap<String, f64>)| {
            let mut candidates: Vec<(String, f64)> = candidates.into_iter().collect();
            candidates.sort_by(|a, b| b.1.total_cmp(&a.1));
            RoleChoice { role, candidates }
        };
        roles.into_iter().filter(|(_, candidates)| candidates.len() > 1).map(record).collect()
    }
}

/// The candidates and the evidence of a path.
fn combination(path: &[&SearchNode]) -> Combination {
    let stages: Vec<f64> = path.iter().filter_map(|node| Some(node.evidence?.ln_marginal)).collect();
    let remarks: Vec<&str> = path.iter().filter_map(|node| node.remark.as_deref()).collect();
    let mut candidates = Choice::new();
    path.iter().for_each(|node| candidates.extend(node.candidates.clone()));
    Combination {
        candidates,
        ln_evidence: stages.iter().sum(),
        stages,
        probability: 0.0,
        remark: Some(remarks.join("; ")).filter(|r| !r.is_empty()),
    }
}
