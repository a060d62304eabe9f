//! The rows of the table of a stage of responses.

use crate::rows::{Choice, Row, are_possible, combinations, with_candidates};
use rijke_study::responses::ResponseStage;
use rijke_study::{Candidate, Study};
use std::collections::BTreeMap;

/// The rows of a stage, with what earlier ones `chose`.
pub(crate) fn rows_of(study: &Study, stage: &ResponseStage, chosen: &BTreeMap<String, Choice>) -> Vec<Row> {
    let catalogue = &study.catalogue;
    let mut base = Choice::new();
    for choice in stage.on.iter().filter_map(|id| chosen.get(id)) {
        base.extend(choice.clone());
    }
    base.extend(stage.with.clone());
    let row = |own: Vec<Candidate>| {
        let choice = with_candidates(base.clone(), &own);
        let own = if own.is_empty() {
            stage.with.values().filter_map(|id| catalogue.get(id).cloned()).collect()
        } else {
            own
        };
        Row { own, choice }
    };
    combinations(catalogue, &stage.compete, &stage.among)
        .into_iter()
        .filter(|own| are_possible(own, &base))
        .map(row)
        .collect()
}
