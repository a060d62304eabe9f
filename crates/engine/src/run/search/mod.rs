//! Every allowed combination of candidates over the stages of a study, trained along the stages that stand on
//! each other.
//!
//! The ln evidence of a combination is the sum of those of its stages, each given what the earlier ones
//! found: the chain rule of probability. It is that of all data together as far as the posterior of a stage
//! is the Gaussian that it hands on, and the misfit of one stage is independent of those of the others.
//!
//! Knows how stages stand on each other, and not what a candidate says.

mod found;
mod models;
mod record;
mod task;
mod tree;

pub use found::merge_searches;
pub use record::{Combination, GivenUp, GreedyChoice, RoleChoice, SearchNode, SearchPart, SearchRecord};

use super::course::{CONTENDS, Chosen, Run, Trusted};
use crate::EngineError;
use crate::rows::Choice;
use rijke_study::{ObservedModes, Study};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use task::{Kept, Names, Outcome, hash};
use tree::{Tree, chain};

/// How a search is made.
#[derive(Clone, Debug)]
pub struct SearchOptions {
    /// The stage at which combinations end; by default the one that stands on most stages.
    pub stage: Option<String>,
    /// A model that trails the greedy choice by more nats, after its stage and also after the last one if it
    /// is continued with the later candidates of the greedy choice, is given up with all that stands on it.
    pub within: f64,
    /// How evidence is checked.
    pub trusted: Trusted,
    /// Which shard of how many, counted from 1: `[1, 1]` is all.
    pub shard: [usize; 2],
    /// How many threads; 0 is one for each processor.
    pub threads: usize,
    /// Where results of tasks are kept, and found again.
    pub tasks: Option<PathBuf>,
}

/// A search that is ready to begin.
pub struct Search {
    run: Run,
    tree: Tree,
    names: Names,
    kept: Kept,
    options: SearchOptions,
}

/// Called with the number of tasks done since the last call; its answer says whether to go on.
type Steps<'a> = &'a (dyn Fn(usize) -> bool + Sync);

/// A model that was visited.
struct Visited {
    task: String,
    trusted: Trusted,
    outcome: Outcome,
    /// ln evidence of its stage and of those before it.
    total: Option<f64>,
}

/// What a search has found so far, by level and node.
struct State {
    visited: Vec<BTreeMap<usize, Visited>>,
    models: Vec<BTreeMap<usize, Chosen>>,
}

impl State {
    fn total(&self, level: usize, k: usize) -> Option<f64> {
        self.visited[level].get(&k)?.total
    }
}

impl Search {
    /// Lists the combinations; nothing is trained yet.
    ///
    /// # Errors
    /// Those of [`Run::new`]; [`EngineError::Refused`] for a stage that is not there or uses stages on which
    /// it does not stand.
    pub fn new(
        mut study: Study,
        observations: &ObservedModes,
        options: SearchOptions,
    ) -> Result<Self, EngineError> {
        study.plan = chain(&study.plan, options.stage.as_deref())?;
        let run = Run::new(study, observations, options.trusted)?;
        let tree = Tree::of(&run.study);
        if tree.combinations() == 0 {
            let stage = run.study.plan.stages.last().map(|s| s.id.clone()).unwrap_or_default();
            let problem =
                "the study allows no combination that reaches it; check its `compete`, `among` and `rows`"
                    .into();
            return Err(EngineError::Refused { stage, problem });
        }
        let [k, n] = options.shard;
        if k == 0 || k > n {
            let stage = run.study.plan.stages.last().map(|s| s.id.clone()).unwrap_or_default();
            let problem = format!("there is no shard {k} of {n}; shards are counted from 1");
            return Err(EngineError::Refused { stage, problem });
        }
        let (names, kept) = (Names::of(&run), Kept(options.tasks.clone()));
        Ok(Self { run, tree, names, kept, options })
    }

    /// Ends the search with [`EngineError::Stopped`] once another thread sets `stopped`.
    #[must_use]
    pub fn stopped_by(mut self, stopped: Arc<AtomicBool>) -> Self {
        self.run.stopped = stopped;
        self
    }

    /// How many combinations there are, in all shards.
    #[must_use]
    pub fn combinations(&self) -> usize {
        self.tree.combinations()
    }

    /// How many tasks this shard has at most.
    #[must_use]
    pub fn tasks(&self) -> usize {
        self.phases() * self.tree.needed(self.options.shard).iter().map(BTreeSet::len).sum::<usize>()
    }

    /// Observed points that no stage uses because nothing is known of their gas.
    #[must_use]
    pub fn left_out(&self) -> &[String] {
        &self.run.left_out
    }

    /// Trains the models of this shard. `step` is called with the number of tasks done since its last call;
    /// it says whether to go on.
    ///
    /// # Errors
    /// [`EngineError::Stopped`]; those of the greedy ranking; a result that cannot be kept. A model that
    /// cannot be fitted is a node without evidence.
    pub fn run(&self, step: &(dyn Fn(usize) -> bool + Sync)) -> Result<SearchPart, EngineError> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(self.options.threads).build();
        let refused = |e: rayon::ThreadPoolBuildError| EngineError::File {
            file: format!("{} threads", self.options.threads),
            problem: e.to_string(),
        };
        pool.map_err(refused)?.install(|| self.levels(step))
    }

    fn levels(&self, step: Steps<'_>) -> Result<SearchPart, EngineError> {
        let greedy = self.greedy(step)?;
        let levels = self.tree.levels.len();
        let mut state = State {
            visited: (0..levels).map(|_| BTreeMap::new()).collect(),
            models: (0..levels).map(|_| BTreeMap::new()).collect(),
        };
        // What all others are compared with.
        for (level, node) in greedy.iter().enumerate() {
            self.visit(&mut state, level, &[*node], &greedy, step)?;
        }
        let mut given_up = BTreeSet::new();
        let mut alive = BTreeSet::from([0]);
        for (level, needed) in self.tree.needed(self.options.shard).iter().enumerate() {
            let of = |k: &usize| &self.tree.levels[level][*k];
            let there: Vec<usize> =
                needed.iter().copied().filter(|k| level == 0 || alive.contains(&of(k).parent)).collect();
            self.visit(&mut state, level, &there, &greedy, step)?;
            let left = self.given_up(&mut state, level, &there, &greedy, step)?;
            let fitted = |k: &usize| state.visited[level].get(k).is_some_and(|v| v.total.is_some());
            alive = there.into_iter().filter(|k| fitted(k) && !left.contains(k)).collect();
            // Of the others no model is wanted any more.
            for (at, models) in state.models.iter_mut().enumerate().skip(level) {
                models.retain(|k, _| greedy[at] == *k || alive.contains(&self.tree.path(at, *k)[level]));
            }
            let open = needed.iter().filter(|k| !state.visited[level].contains_key(k)).count();
            step(self.phases() * open);
            given_up.extend(left.into_iter().map(|k| (level, k)));
        }
        let within = Some(self.options.within).filter(|w| w.is_finite());
        let plan = &self.run.study.plan;
        let nodes = state.visited.into_iter().enumerate().flat_map(|(level, visited)| {
            visited.into_iter().map(move |(k, Visited { task, outcome, .. })| (level, k, task, outcome))
        });
        let node = |(level, k, task, outcome): (usize, usize, String, Outcome)| {
            let node = &self.tree.levels[level][k];
            SearchNode {
                level,
                node: k,
                parent: node.parent,
                combinations: node.combinations,
                candidates: Choice::clone(&node.choice),
                task,
                evidence: outcome.evidence,
                remark: outcome.remark,
                given_up: given_up.contains(&(level, k)),
                continued: self.tree.continued(level, k, &greedy)[levels - 1],
            }
        };
        let nodes = nodes.map(node).collect();
        Ok(SearchPart {
            search: hash(&[&self.names.greedy(), &format!("{within:?}")]),
            study: plan.name.clone(),
            stages: plan.stages.iter().map(|s| s.id.clone()).collect(),
            within,
            shard: self.options.shard,
            combinations: self.combinations(),
            models: self.tree.levels.iter().map(Vec::len).sum(),
            greedy,
            nodes,
        })
    }

    /// Those of `nodes` that trail the greedy choice by too much, both up to their level and at the end, if
    /// they are continued with its later candidates.
    fn given_up(
        &self,
        state: &mut State,
        level: usize,
        nodes: &[usize],
        greedy: &[usize],
        step: Steps<'_>,
    ) -> Result<BTreeSet<usize>, EngineError> {
        let last = self.tree.levels.len() - 1;
        let trails = |state: &State, level: usize, k: usize| {
            let least =
                state.total(level, greedy[level]).map_or(f64::NEG_INFINITY, |t| t - self.options.within);
            state.total(level, k).is_some_and(|total| total < least)
        };
        let trailing: Vec<usize> =
            nodes.iter().copied().filter(|k| level < last && trails(state, level, *k)).collect();
        let continued: Vec<Vec<usize>> =
            trailing.iter().map(|k| self.tree.continued(level, *k, greedy)).collect();
        for later in level + 1..=last {
            // One that could not be fitted does not go on.
            let fitted = |path: &&Vec<usize>| state.total(later - 1, path[later - 1]).is_some();
            let nodes: BTreeSet<usize> = continued.iter().filter(fitted).map(|path| path[later]).collect();
            self.visit(state, later, &nodes.into_iter().collect::<Vec<_>>(), greedy, step)?;
        }
        let at_the_end = |path: &Vec<usize>| trails(state, last, path[last]);
        Ok(trailing.iter().zip(&continued).filter(|(_, path)| at_the_end(path)).map(|(k, _)| *k).collect())
    }

    /// Trains nodes of a level, or takes what was kept of them.
    fn visit(
        &self,
        state: &mut State,
        level: usize,
        nodes: &[usize],
        greedy: &[usize],
        step: Steps<'_>,
    ) -> Result<(), EngineError> {
        let nodes: Vec<usize> =
            nodes.iter().copied().filter(|k| !state.visited[level].contains_key(k)).collect();
        self.outcomes(state, level, &nodes, Trusted::Laplace, step)?;
        if self.options.trusted != Trusted::Laplace {
            // As a ranking does it: checks cost far more than the first fit.
            let least = state.total(level, greedy[level]).map_or(f64::NEG_INFINITY, |t| t - CONTENDS);
            let contends = |state: &State, k: usize| state.total(level, k).is_none_or(|total| total >= least);
            let behind: Vec<usize> = nodes.iter().copied().filter(|k| !contends(state, *k)).collect();
            self.outcomes(state, level, &behind, Trusted::Searched, step)?;
            let checked: Vec<usize> = nodes.into_iter().filter(|k| contends(state, *k)).collect();
            self.outcomes(state, level, &checked, self.options.trusted, step)?;
        }
        Ok(())
    }

    /// How often a model is trained: checks come after a first fit.
    fn phases(&self) -> usize {
        if self.options.trusted == Trusted::Laplace { 1 } else { 2 }
    }
}
