//! Whether the questions of a study can be answered at their points, before anything is trained.

use super::answers::{check, foreseen};
use super::combined::{assembly_of, first_of_responses, rows_of};
use super::points::inputs::{ambient_of_all, conditions, states};
use crate::rows::{Choice, Row};
use crate::{Assembly, Conditions, EngineError, PointModel};
use rijke_network::{NetworkError, Workspace};
use rijke_numerics::{C64, Order};
use rijke_study::plan::Selection;
use rijke_study::{ObservedModes, PointState, Study};
use std::collections::BTreeMap;

/// Refuses a question that asks for a prediction at a point where a model that may win its stage is
/// undefined: the first combination of each earlier stage is taken, parameters are at the centre of their
/// priors. A point of whose gas nothing is known is passed over, as in the answer.
///
/// # Errors
/// [`EngineError::Unanswerable`], and those of the files.
pub fn answerable(study: &Study, observations: &ObservedModes) -> Result<(), EngineError> {
    check(study)?;
    if asked(study)?.is_empty() {
        return Ok(());
    }
    let ambient = ambient_of_all(study, observations);
    let states = states(study, &ambient, true)?;
    at_all_points(study, &states, &ambient)
}

/// A question that needs the model of its stage at some points.
struct AskedAt {
    question: String,
    stage: String,
    points: Selection,
}

/// The questions that need a model at points.
fn asked(study: &Study) -> Result<Vec<AskedAt>, EngineError> {
    let mut all = Vec::new();
    for question in &study.plan.questions {
        let (stage, id) = (question.stage.clone(), question.id.clone());
        all.extend(foreseen(question)?.map(|points| AskedAt { question: id, stage, points }));
    }
    Ok(all)
}

/// As [`answerable`], of what is known of the gas at every point.
pub(super) fn at_all_points(
    study: &Study,
    states: &BTreeMap<usize, PointState>,
    ambient: &[Option<[f64; 2]>],
) -> Result<(), EngineError> {
    let asked = asked(study)?;
    let mut done: BTreeMap<String, Choice> = first_of_responses(study);
    for stage in &study.plan.stages {
        let rows = rows_of(study, stage, &|id| done.get(id).cloned().into_iter().collect());
        let questions: Vec<_> = asked.iter().filter(|q| q.stage == stage.id).collect();
        let model = |row: &Row| assembly_of(study, &row.choice, &stage.hold);
        let open = rows.iter().filter(|_| !questions.is_empty());
        let models: Vec<Assembly> = open.map(model).collect::<Result<_, _>>()?;
        for AskedAt { question, points, .. } in questions {
            let meant = study.campaign.points.iter().enumerate();
            for (k, point) in meant.filter(|(_, p)| points.holds(&study.campaign, p)) {
                let Ok(conditions) = conditions(study, point, states.get(&k), ambient[k]) else { continue };
                for (row, assembly) in rows.iter().zip(&models) {
                    if let Some(source) = undefined(study, assembly, &conditions) {
                        let model = row.choice.values().cloned().collect::<Vec<_>>().join(" + ");
                        let (question, source) = (question.clone(), Box::new(source));
                        return Err(EngineError::Unanswerable { question, model, source });
                    }
                }
            }
        }
        if let Some(row) = rows.into_iter().next() {
            done.insert(stage.id.clone(), row.choice);
        }
    }
    Ok(())
}

/// Why a model is undefined under these conditions, in the middle of the frequencies of
/// the search; nothing if it is defined.
fn undefined(study: &Study, assembly: &Assembly, conditions: &Conditions) -> Option<EngineError> {
    let values: Vec<f64> = assembly.parameters().iter().map(|p| p.prior.quantile(0.5)).collect();
    let [low, high] = study.rig.search[1];
    let middle = C64::new(0.0, std::f64::consts::PI * (low + high));
    let found = PointModel::new(assembly, conditions, &[]).and_then(|model| {
        model.starting_from(middle).respond(&values, Order::Value, &mut Workspace::default())
    });
    match found {
        Err(why @ EngineError::Network { source: NetworkError::NotFinite { .. }, .. }) => Some(why),
        _ => None,
    }
}
