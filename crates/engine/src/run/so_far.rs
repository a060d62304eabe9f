//! A study as far as it has been measured.

use super::points::inputs::{ambient_of_all, selected, states};
use super::points::meant::observed;
use super::record::StageRecord;
use crate::EngineError;
use rijke_study::plan::{SdSpec, Stage};
use rijke_study::{ObservedModes, Study};
use std::collections::BTreeMap;

/// The candidates of a stage that are worth training while a campaign goes on, by stage.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Leading(BTreeMap<String, Vec<String>>);

impl Leading {
    /// The `count` models of most evidence of every stage.
    #[must_use]
    pub fn of(stages: &[StageRecord], count: usize) -> Self {
        let best = |stage: &StageRecord| {
            let leading = stage.by_evidence().into_iter().take(count).map(|m| m.id.clone()).collect();
            (stage.id.clone(), leading)
        };
        Self(stages.iter().map(best).collect())
    }

    /// Leaves the candidates of a stage that lead; all where several roles compete, or where none is known.
    fn narrow(&self, stage: &mut Stage) {
        let Some(leading) = self.0.get(&stage.id).filter(|_| stage.compete.len() == 1) else { return };
        let leads = |ids: &[String]| leading.contains(&ids.join(" + "));
        stage.rows.retain(|row| leads(row));
        // Names of further rows hold a ` + `, or name candidates of another role.
        let further: Vec<String> = stage.rows.iter().map(|row| row.join(" + ")).collect();
        let own: Vec<String> = leading.iter().filter(|id| !further.contains(id)).cloned().collect();
        if !own.is_empty() {
            stage.among = own;
        }
    }
}

/// The stages that have observed points and stand on such stages only, with the candidates that lead; without
/// questions.
///
/// # Errors
/// Those of the files of the base state.
pub fn so_far(
    study: &Study,
    observations: &ObservedModes,
    leading: &Leading,
) -> Result<Option<Study>, EngineError> {
    let ambient = ambient_of_all(study, observations);
    let states = states(study, &ambient, false)?;
    let mut reduced = study.clone();
    reduced.plan.questions.clear();
    reduced.plan.maps.clear();
    // Points of which the gas is not known yet count as not measured.
    let observed = match observed(study, observations, &states, &ambient) {
        Ok(observed) => observed,
        Err(EngineError::NoState { .. }) => return Ok(None),
        Err(other) => return Err(other),
    };
    let mut kept: Vec<Stage> = Vec::new();
    for stage in &study.plan.stages {
        let stands = |id: &String| kept.iter().any(|s| s.id == *id);
        let noises = [Some(&stage.noise), stage.noise_of_predictions.as_ref()];
        let alike = noises.into_iter().flatten().flat_map(|n| n.all()).all(|sd| match sd {
            SdSpec::Like { stage, .. } => stands(stage),
            _ => true,
        });
        let earlier = stage.on.iter().chain(&stage.heard_through).all(stands);
        if earlier && alike && !selected(study, &observed, &stage.points).is_empty() {
            let mut stage = stage.clone();
            leading.narrow(&mut stage);
            kept.push(stage);
        }
    }
    reduced.plan.stages = kept;
    Ok((!reduced.plan.stages.is_empty()).then_some(reduced))
}
