//! From a study and its observations to its first stage.

use super::answerable::at_all_points;
use super::answers;
use super::course::{Near, Run, Trusted};
use super::points::inputs::{ambient_of_all, left_out, selected, states_and_heat};
use super::points::meant::observed;
use crate::EngineError;
use crate::response::Ground;
use rijke_study::plan::Stage;
use rijke_study::{ObservedModes, Study};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

impl Run {
    /// Reads what a study needs before its first stage.
    ///
    /// # Errors
    /// Those of the files; an operating point without temperature or frequency; a stage that stands on one of
    /// responses, for which see [`Run::on_responses`].
    pub fn new(study: Study, observations: &ObservedModes, trusted: Trusted) -> Result<Self, EngineError> {
        Self::on_responses(study, observations, trusted, Vec::new())
    }

    /// As [`Run::new`], with what the study's stages of responses found
    /// ([`ResponseRun::grounds`](crate::response::ResponseRun::grounds)). A stage that stands on them may
    /// have no observed point: its models are as the responses have them.
    ///
    /// # Errors
    /// As [`Run::new`].
    pub fn on_responses(
        study: Study,
        observations: &ObservedModes,
        trusted: Trusted,
        grounds: Vec<Ground>,
    ) -> Result<Self, EngineError> {
        for stage in &study.plan.stages {
            let known = |id: &str| grounds.iter().any(|g| g.id == id);
            if let Some(id) = study.plan.grounds(stage).into_iter().find(|id| !known(id)) {
                let problem = format!(
                    "it stands on `{id}`, which trains on responses: train that first, with `rijke rank`"
                );
                return Err(EngineError::Refused { stage: stage.id.clone(), problem });
            }
        }
        answers::check(&study)?;
        let (rig, channels) = (Arc::new(study.rig.clone()), study.channels()?);
        let ambient = ambient_of_all(&study, observations);
        let (states, heat) = states_and_heat(&study, &ambient, true)?;
        let observed = observed(&study, observations, &states, &ambient)?;
        let left_out = left_out(&study, observations, &states);
        // Before anything is trained.
        let idle = |stage: &&Stage| {
            selected(&study, &observed, &stage.points).is_empty() && study.plan.grounds(stage).is_empty()
        };
        if let Some(stage) = study.plan.stages.iter().find(idle) {
            return Err(EngineError::no_point(&study, &stage.id, &stage.points));
        }
        at_all_points(&study, &states, &ambient)?;
        Ok(Self {
            study,
            rig,
            observed,
            channels,
            trusted,
            grounds,
            done: Vec::new(),
            heat,
            left_out,
            states,
            ambient,
            near: Near::new(),
            once: Arc::default(),
            predicting: Mutex::<BTreeMap<_, _>>::default(),
            lengths: false,
            stopped: Arc::default(),
        })
    }
}
