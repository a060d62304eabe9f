//! The rows of the table of a stage of responses.

use crate::run::{are_possible, with_candidates};
use rijke_study::responses::ResponseStage;
use rijke_study::{Candidate, Study};
use std::collections::BTreeMap;

/// One row of a table: the candidates in question, and role and candidate of the whole model.
pub(crate) struct Row {
    pub(crate) own: Vec<Candidate>,
    pub(crate) choice: BTreeMap<String, String>,
}

impl Row {
    /// What the table calls it.
    pub(super) fn id(&self) -> String {
        self.own.iter().map(|c| c.id.as_str()).collect::<Vec<_>>().join(" + ")
    }
}

/// The rows of a stage, with what earlier ones `chose`.
pub(crate) fn rows_of(
    study: &Study,
    stage: &ResponseStage,
    chosen: &BTreeMap<String, BTreeMap<String, String>>,
) -> Vec<Row> {
    let catalogue = &study.catalogue;
    let mut base: BTreeMap<String, String> = BTreeMap::new();
    for choice in stage.on.iter().filter_map(|id| chosen.get(id)) {
        base.extend(choice.clone());
    }
    base.extend(stage.with.clone());
    let mut lists: Vec<Vec<Candidate>> = vec![Vec::new()];
    for role in &stage.compete {
        let named = |c: &&Candidate| stage.among.is_empty() || stage.among.contains(&c.id);
        let competing: Vec<Candidate> =
            catalogue.competing(role).into_iter().filter(named).cloned().collect();
        lists = lists
            .into_iter()
            .flat_map(|list| competing.iter().map(move |c| [list.clone(), vec![c.clone()]].concat()))
            .collect();
    }
    let row = |own: Vec<Candidate>| {
        let choice = with_candidates(base.clone(), &own);
        let own = if own.is_empty() {
            stage.with.values().filter_map(|id| catalogue.get(id).cloned()).collect()
        } else {
            own
        };
        Row { own, choice }
    };
    lists.into_iter().filter(|own| are_possible(own, &base)).map(row).collect()
}
