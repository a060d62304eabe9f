//! The models that a stage trains, from what competes and what earlier stages leave open.

use crate::rows::{Choice, Row, are_possible, combinations, with_candidates};
use crate::{Assembly, EngineError};
use rijke_study::plan::Stage;
use rijke_study::{Candidate, Study};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The rows of the table of a stage; `before` is what each earlier stage chose, and after it what it left
/// open, if the stage must weigh that.
pub(super) fn rows_of(study: &Study, stage: &Stage, before: &dyn Fn(&str) -> Vec<Choice>) -> Vec<Row> {
    let catalogue = &study.catalogue;
    // What it takes from stages before it, and what it names itself.
    let mut base = Choice::new();
    let before: Vec<Vec<Choice>> = stage.on.iter().map(|id| before(id)).collect();
    before.iter().filter_map(|all| all.first()).for_each(|choice| base.extend(choice.clone()));
    base.retain(|role, _| !stage.without.contains(role));
    base.extend(stage.with.clone());
    let mut lists = match stage.compete.is_empty() {
        true => Vec::new(),
        false => combinations(catalogue, &stage.compete, &stage.among),
    };
    for ids in &stage.rows {
        lists.push(ids.iter().filter_map(|id| catalogue.get(id).cloned()).collect());
    }
    let open: Vec<Vec<Vec<Candidate>>> =
        before.iter().map(|all| left_open(study, stage, all)).filter(|all| !all.is_empty()).collect();
    if lists.is_empty() && !open.is_empty() {
        lists.push(Vec::new());
    }
    for all in &open {
        let with = |list: Vec<Candidate>| all.iter().map(move |own| [own.clone(), list.clone()].concat());
        lists = lists.into_iter().flat_map(with).collect();
    }
    if lists.is_empty() {
        // A stage that trains one model: the candidates that it names, in question together.
        lists.push(stage.with.values().filter_map(|id| catalogue.get(id).cloned()).collect());
    }
    let row = |own: Vec<Candidate>| Row { choice: with_candidates(base.clone(), &own), own };
    lists.into_iter().filter(|own| are_possible(own, &base)).map(row).collect()
}

/// The first model of every stage of responses, before anything is trained.
pub(super) fn first_of_responses(study: &Study) -> BTreeMap<String, Choice> {
    let mut chosen: BTreeMap<String, Choice> = BTreeMap::new();
    for stage in &study.plan.responses {
        let first = crate::response::rows_of(study, stage, &chosen).into_iter().next();
        chosen.extend(first.map(|row| (stage.id.clone(), row.choice)));
    }
    chosen
}

/// The candidates by which the models that an earlier stage leaves open differ, one list for each of them;
/// none where there is one only, or where candidates of these roles are named by the stage.
fn left_open(study: &Study, stage: &Stage, all: &[Choice]) -> Vec<Vec<Candidate>> {
    let Some((first, others)) = all.split_first().filter(|(_, others)| !others.is_empty()) else {
        return Vec::new();
    };
    let role = |id: &String| study.catalogue.get(id).map(|c| c.role.as_str());
    let rows = stage.rows.iter().flatten().filter_map(role);
    let named: Vec<&str> = stage
        .compete
        .iter()
        .chain(stage.with.keys())
        .chain(&stage.without)
        .map(String::as_str)
        .chain(rows)
        .collect();
    let differs = |role: &&String| others.iter().any(|o| o.get(*role) != first.get(*role));
    let roles: Vec<&String> = first.keys().filter(differs).collect();
    if roles.iter().any(|role| named.contains(&role.as_str())) {
        return Vec::new();
    }
    let of = |choice: &Choice| {
        roles.iter().filter_map(|role| study.catalogue.get(choice.get(*role)?).cloned()).collect()
    };
    all.iter().map(of).collect()
}

/// The model of one candidate per role.
pub(super) fn assembly_of(
    study: &Study,
    choice: &Choice,
    hold: &BTreeMap<String, f64>,
) -> Result<Assembly, EngineError> {
    let candidates = choice.values().filter_map(|id| study.catalogue.get(id).cloned()).collect();
    Assembly::new(Arc::new(study.rig.clone()), candidates, hold)
}

/// The model of the first row of the last stage, at the centre of its priors.
///
/// # Errors
/// [`EngineError::NoPoint`] for a study without stages.
pub(super) fn first_model(study: &Study) -> Result<(Assembly, Vec<f64>), EngineError> {
    let mut done: BTreeMap<String, Choice> = first_of_responses(study);
    for stage in &study.plan.stages {
        let rows = rows_of(study, stage, &|id| done.get(id).cloned().into_iter().collect());
        if let Some(row) = rows.into_iter().next() {
            done.insert(stage.id.clone(), row.choice);
        }
    }
    let last = study.plan.stages.iter().rev().find_map(|s| Some((s, done.get(&s.id)?)));
    let (stage, choice) = last.ok_or_else(|| EngineError::NoPoint { stage: study.plan.name.clone() })?;
    let assembly = assembly_of(study, choice, &stage.hold)?;
    let values = assembly.parameters().iter().map(|p| p.prior.quantile(0.5)).collect();
    Ok((assembly, values))
}
