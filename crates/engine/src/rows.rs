//! Models as rows of a stage's table, whatever the stage has measured: which candidates are in question, and
//! which whole model each of them makes.

use rijke_study::{Candidate, Catalogue};
use std::collections::BTreeMap;

/// Role and candidate of a whole model.
pub(crate) type Choice = BTreeMap<String, String>;

/// One row of a table.
#[derive(Default)]
pub(crate) struct Row {
    /// The candidates in question.
    pub(crate) own: Vec<Candidate>,
    /// The whole model.
    pub(crate) choice: Choice,
}

impl Row {
    /// What the table calls it; without candidates it is the model of the rig alone.
    pub(crate) fn id(&self) -> String {
        if self.own.is_empty() {
            return "the rig".to_owned();
        }
        self.own.iter().map(|c| c.id.as_str()).collect::<Vec<_>>().join(" + ")
    }
}

/// One candidate of every role that competes, in all combinations; of those `among`, unless that is empty.
/// Without a role, one list without a candidate.
pub(crate) fn combinations(
    catalogue: &Catalogue,
    compete: &[String],
    among: &[String],
) -> Vec<Vec<Candidate>> {
    let mut lists: Vec<Vec<Candidate>> = vec![Vec::new()];
    for role in compete {
        let named = |c: &&Candidate| among.is_empty() || among.contains(&c.id);
        let competing: Vec<&Candidate> = catalogue.competing(role).into_iter().filter(named).collect();
        let longer = |list: Vec<Candidate>| {
            let one = |c: &&Candidate| [list.clone(), vec![(*c).clone()]].concat();
            competing.iter().map(one).collect::<Vec<_>>()
        };
        lists = lists.into_iter().flat_map(longer).collect();
    }
    lists
}

/// Whether a model of these candidates can be: one that extends another can be part of no model without it.
pub(crate) fn are_possible(own: &[Candidate], base: &Choice) -> bool {
    own.iter().all(|c| c.extends.as_ref().is_none_or(|id| base.values().any(|b| b == id)))
}

/// A model with some candidates in the places of others.
pub(crate) fn with_candidates(mut choice: Choice, own: &[Candidate]) -> Choice {
    for candidate in own {
        if let Some(extended) = &candidate.extends {
            choice.retain(|_, id| id != extended);
        }
        choice.insert(candidate.role.clone(), candidate.id.clone());
    }
    choice
}
