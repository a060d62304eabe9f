//! The combinations that a study allows, as a tree: a level per stage, and a node for every choice of
//! candidates up to that stage.

use crate::EngineError;
use crate::rows::Choice;
use crate::run::combined::rows_of;
use rijke_study::Study;
use rijke_study::plan::{Plan, SdSpec, Stage};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// A model of one stage on models of the stages before it.
pub(super) struct Node {
    /// Its place in the level before.
    pub(super) parent: usize,
    pub(super) choice: Arc<Choice>,
    /// How many combinations hold it.
    pub(super) combinations: usize,
}

/// All combinations.
pub(super) struct Tree {
    pub(super) levels: Vec<Vec<Node>>,
}

/// The plan with only those stages on which the stage called `target` stands, and that stage; by default the
/// one that stands on most, the last if there are several.
pub(super) fn chain(plan: &Plan, target: Option<&str>) -> Result<Plan, EngineError> {
    let ids = || plan.stages.iter().map(|s| s.id.as_str()).collect::<Vec<_>>();
    let below = |id: &str| {
        let mut found = BTreeSet::new();
        let mut open = vec![id];
        while let Some((k, stage)) = open.pop().and_then(|id| plan.stage(id)) {
            if found.insert(k) {
                open.extend(stage.on.iter().map(String::as_str));
            }
        }
        found
    };
    let target = match target {
        Some(id) if plan.stage(id).is_some() => id,
        Some(id) => {
            let problem = format!("the study has no such stage; give one of {}", ids().join(", "));
            return Err(EngineError::Refused { stage: id.to_owned(), problem });
        }
        None => ids().into_iter().max_by_key(|id| below(id).len()).unwrap_or_default(),
    };
    let kept = below(target);
    let stages: Vec<Stage> = kept.iter().map(|k| plan.stages[*k].clone()).collect();
    for stage in &stages {
        let like = stage.noise.all().filter_map(|sd| match sd {
            SdSpec::Like { stage, .. } => Some(stage),
            _ => None,
        });
        if let Some(other) =
            stage.heard_through.iter().chain(like).find(|id| stages.iter().all(|s| s.id != **id))
        {
            let problem = format!(
                "it takes channels or noise from `{other}`, on which it does not stand, so no evidence of both is one sum; search a stage \
                 that stands on all that it uses"
            );
            return Err(EngineError::Refused { stage: stage.id.clone(), problem });
        }
    }
    Ok(Plan { stages, questions: Vec::new(), maps: Vec::new(), ..plan.clone() })
}

/// The candidates that a later model has, in the stages on which `stage` stands.
pub(super) fn settle(study: &Study, stage: &Stage, choice: &Choice, path: &mut [Arc<Choice>]) {
    for (k, earlier) in stage.on.iter().filter_map(|id| study.plan.stage(id)) {
        let Some(own) = path.get(k) else { continue };
        let mut settled = Choice::clone(own);
        for (role, id) in &mut settled {
            if let Some(other) = choice.get(role) {
                id.clone_from(other);
            }
        }
        if settled != **own {
            path[k] = Arc::new(settled.clone());
        }
        settle(study, earlier, &settled, path);
    }
}

impl Tree {
    /// Every combination of the rows of the tables of all stages of `study`, whose plan is a [`chain`].
    pub(super) fn of(study: &Study) -> Self {
        let mut levels: Vec<Vec<Node>> = study.plan.stages.iter().map(|_| Vec::new()).collect();
        let mut places = vec![BTreeMap::new(); levels.len()];
        let mut add = |path: &[Arc<Choice>]| {
            let mut parent = 0;
            for (level, choice) in path.iter().enumerate() {
                let nodes = &mut levels[level];
                parent = *places[level].entry((parent, choice.clone())).or_insert_with(|| {
                    nodes.push(Node { parent, choice: choice.clone(), combinations: 0 });
                    nodes.len() - 1
                });
            }
        };
        grow(study, &[], &mut add);
        let mut tree = Self { levels };
        if let Some(leaves) = tree.levels.last_mut() {
            leaves.iter_mut().for_each(|leaf| leaf.combinations = 1);
        }
        for level in (1..tree.levels.len()).rev() {
            for k in 0..tree.levels[level].len() {
                let Node { parent, combinations, .. } = tree.levels[level][k];
                tree.levels[level - 1][parent].combinations += combinations;
            }
        }
        tree
    }

    pub(super) fn combinations(&self) -> usize {
        self.levels.last().map_or(0, Vec::len)
    }

    /// The nodes from the first level to node `k` of `level`.
    pub(super) fn path(&self, level: usize, k: usize) -> Vec<usize> {
        let mut path = vec![k];
        for level in (1..=level).rev() {
            path.push(self.levels[level][path[path.len() - 1]].parent);
        }
        path.reverse();
        path
    }

    /// The nodes of one combination.
    pub(super) fn find(&self, choices: &[Choice]) -> Option<Vec<usize>> {
        let last = self.levels.len() - 1;
        let same = |path: &Vec<usize>| {
            path.iter().zip(choices).enumerate().all(|(j, (k, choice))| *self.levels[j][*k].choice == *choice)
        };
        (0..self.combinations()).map(|k| self.path(last, k)).find(same)
    }

    /// The nodes from the first level to the last through node `k` of `level`, with those candidates of the
    /// combination `greedy` in later stages that are possible there.
    pub(super) fn continued(&self, level: usize, k: usize, greedy: &[usize]) -> Vec<usize> {
        let mut path = self.path(level, k);
        for later in path.len()..self.levels.len() {
            let nodes = &self.levels[later];
            let parent = path[path.len() - 1];
            let (wanted, before) = (&nodes[greedy[later]], &self.levels[later - 1][greedy[later - 1]]);
            let news = wanted.choice.iter().filter(|(role, id)| before.choice.get(*role) != Some(id));
            let alike =
                |node: &Node| news.clone().filter(|(role, id)| node.choice.get(*role) == Some(id)).count();
            let children = (0..nodes.len()).filter(|k| nodes[*k].parent == parent);
            // Of several that are as much alike, the first.
            path.extend(children.rev().max_by_key(|k| alike(&nodes[*k])));
        }
        path
    }

    /// For every level, the nodes that shard `[k, n]`, counted from 1, has to visit. The first level with
    /// [`SPREAD`] nodes for each shard is dealt out in turn; what lies before it is visited by every shard
    /// that builds on it.
    pub(super) fn needed(&self, [k, n]: [usize; 2]) -> Vec<BTreeSet<usize>> {
        let last = self.levels.len() - 1;
        let dealt = self.levels.iter().position(|level| level.len() >= SPREAD * n).unwrap_or(last);
        let mut needed = vec![BTreeSet::new(); last + 1];
        for leaf in 0..self.combinations() {
            let path = self.path(last, leaf);
            if path[dealt] % n == k - 1 {
                path.into_iter().enumerate().for_each(|(level, node)| needed[level].extend([node]));
            }
        }
        needed
    }
}

/// Subtrees for each shard, at least: with fewer, shards differ much in work; with more, they share more of
/// the first stages.
const SPREAD: usize = 8;

fn grow(study: &Study, path: &[Arc<Choice>], add: &mut dyn FnMut(&[Arc<Choice>])) {
    let Some(stage) = study.plan.stages.get(path.len()) else { return add(path) };
    let chosen = |id: &str| study.plan.stage(id).and_then(|(k, _)| Some(Choice::clone(path.get(k)?)));
    let before = |id: &str| chosen(id).into_iter().collect();
    for row in rows_of(study, stage, &before) {
        let mut path = path.to_vec();
        settle(study, stage, &row.choice, &mut path);
        path.push(Arc::new(row.choice));
        grow(study, &path, add);
    }
}
