//! What shards found, joined: probabilities of combinations, of each choice, and of what was given up.

use super::record::{Combination, GivenUp, GreedyChoice, RoleChoice, SearchNode, SearchPart, SearchRecord};
use crate::EngineError;
use crate::rows::Choice;
use std::collections::{BTreeMap, BTreeSet};

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
        let what = match missing.is_empty() {
            true => "one of them was damaged: make the parts again".to_owned(),
            false => format!("make shard {} of {n} too", missing.join(", ")),
        };
        return refuse(format!("the parts hold {reached} of {} combinations; {what}", first.combinations));
    }
    if !whole.ends().any(|node| node.level + 1 == first.stages.len() && node.evidence.is_some()) {
        let why = whole.ends().filter_map(|node| node.remark.clone()).next().unwrap_or_default();
        return refuse(format!("no combination could be trained to the last stage; {why}"));
    }
    Ok(whole.record())
}

/// The nodes of a whole search.
struct Whole<'a> {
    first: &'a SearchPart,
    nodes: BTreeMap<(usize, usize), &'a SearchNode>,
}

impl<'a> Whole<'a> {
    fn is_end(&self, node: &SearchNode) -> bool {
        node.level + 1 == self.first.stages.len() || node.given_up || node.evidence.is_none()
    }

    /// Whether it was given up, or stands on one that was.
    fn is_given_up(&self, node: &'a SearchNode) -> bool {
        self.path(node).iter().any(|node| node.given_up)
    }

    /// The nodes at which the tree was left, each combination under one of them; and no others.
    fn ends(&self) -> impl Iterator<Item = &'a SearchNode> {
        let below = |node: &SearchNode| {
            let before = node.level.checked_sub(1).and_then(|l| self.nodes.get(&(l, node.parent)));
            before.is_some_and(|before| self.is_given_up(before))
        };
        self.nodes.values().copied().filter(move |node| self.is_end(node) && !below(node))
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
            .nodes
            .values()
            .filter(|node| node.level == last && node.evidence.is_some())
            .map(|node| (node.node, combination(&self.path(node))))
            .collect();
        best.sort_by(|(a, one), (b, two)| two.ln_evidence.total_cmp(&one.ln_evidence).then(a.cmp(b)));
        let most = best.first().map_or(f64::NEG_INFINITY, |(_, c)| c.ln_evidence);
        // Equation (7), over combinations.
        let sum: f64 = best.iter().map(|(_, c)| (c.ln_evidence - most).exp()).sum();
        best.iter_mut().for_each(|(_, c)| c.probability = (c.ln_evidence - most).exp() / sum);
        let ends: BTreeMap<usize, f64> = best.iter().map(|(k, c)| (*k, c.ln_evidence)).collect();
        // Under each node: how many combinations were trained to the end, and the best of them.
        let mut under: BTreeMap<(usize, usize), (usize, f64)> = BTreeMap::new();
        for (k, ln) in &ends {
            for node in self.nodes.get(&(last, *k)).map(|leaf| self.path(leaf)).into_iter().flatten() {
                let (count, best) = under.entry((node.level, node.node)).or_insert((0, f64::NEG_INFINITY));
                (*count, *best) = (*count + 1, best.max(*ln));
            }
        }
        let mut gained = vec![0.0_f64; stages.len()];
        for node in self.nodes.values().filter(|node| !self.is_given_up(node)) {
            if let (Some((_, best)), Some(ln)) =
                (under.get(&(node.level, node.node)), ends.get(&node.continued))
            {
                gained[node.level] = gained[node.level].max(best - ln);
            }
        }
        let left = |node: &'a SearchNode| {
            let Combination { candidates, ln_evidence, remark, .. } = combination(&self.path(node));
            let ln_evidence = node.evidence.map(|_| ln_evidence);
            let trained = under.get(&(node.level, node.node)).map_or(0, |(count, _)| *count);
            let combinations = node.combinations - trained;
            let continued = ends.get(&node.continued).map_or(f64::NEG_INFINITY, |ln| ln + gained[node.level]);
            let weight = combinations as f64 * (continued - most).exp();
            let stage = stages[node.level].clone();
            (weight, GivenUp { stage, candidates, combinations, ln_evidence, at_most: 0.0, remark })
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
            gained,
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
        remark: Some(remarks.join("\n")).filter(|r| !r.is_empty()),
    }
}
