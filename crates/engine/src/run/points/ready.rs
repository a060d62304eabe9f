//! What is known of the points of a study, and a saved model that is ready to be asked at them.

use super::super::combined::assembly_of;
use super::followed::Followed;
use super::inputs::{ambient_of_all, conditions, states};
use super::meant::observed;
use crate::{Assembly, Conditions, EngineError, Observed, SavedModel, TrainedPosterior};
use rijke_study::{ObservedModes, PointState, Study};
use std::collections::BTreeMap;

/// What is known of the points of a study, whatever the model.
pub(in crate::run) struct Known<'a> {
    pub(in crate::run) study: &'a Study,
    /// Ambient temperature and its standard deviation at every point, K.
    ambient: Vec<Option<[f64; 2]>>,
    states: BTreeMap<usize, PointState>,
    pub(in crate::run) observed: Vec<Observed>,
}

impl<'a> Known<'a> {
    pub(in crate::run) fn of(study: &'a Study, observations: &ObservedModes) -> Result<Self, EngineError> {
        let states = states(study, &ambient_of_all(study, observations), true)?;
        Self::of_states(study, observations, states)
    }

    /// Where the states of the gas are known.
    pub(in crate::run) fn of_states(
        study: &'a Study,
        observations: &ObservedModes,
        states: BTreeMap<usize, PointState>,
    ) -> Result<Self, EngineError> {
        let ambient = ambient_of_all(study, observations);
        let observed = observed(study, observations, &states, &ambient)?;
        Ok(Self { study, ambient, states, observed })
    }

    /// The observations that trained a model.
    pub(in crate::run) fn trained(&self, model: &SavedModel) -> Vec<Observed> {
        let trained = |o: &&Observed| model.trained_on.contains(&o.conditions.id);
        self.observed.iter().filter(trained).cloned().collect()
    }
}

/// A saved model, ready to be asked at any point.
pub(in crate::run) struct Ready<'a> {
    pub(in crate::run) known: &'a Known<'a>,
    pub(in crate::run) model: &'a SavedModel,
    pub(in crate::run) followed: Followed<'a>,
    pub(in crate::run) assembly: Assembly,
    pub(in crate::run) posterior: TrainedPosterior,
    /// Ambient temperature of a point that was not measured: nothing else is known of it.
    usual: Option<[f64; 2]>,
}

impl<'a> Ready<'a> {
    pub(in crate::run) fn of(known: &'a Known<'a>, model: &'a SavedModel) -> Result<Self, EngineError> {
        let campaign = &known.study.campaign;
        let trained = || model.trained_on.iter().filter_map(|id| campaign.point(id).map(|(k, _)| k));
        Ok(Self {
            known,
            model,
            followed: Followed::of(known.study, &known.observed, &model.trained_on),
            assembly: assembly_of(known.study, &model.candidates, &model.hold)?,
            posterior: model.posterior()?,
            usual: trained().find_map(|k| known.ambient[k]),
        })
    }

    /// The conditions at a point of the campaign, where they can be known: a model that was trained with
    /// inferred states needs one.
    pub(in crate::run) fn conditions(&self, k: usize) -> Result<Conditions, EngineError> {
        let Known { study, ambient, states, .. } = self.known;
        conditions(study, &study.campaign.points[k], states.get(&k), ambient[k].or(self.usual))
    }

    /// Name of a point of the campaign.
    pub(in crate::run) fn id(&self, k: usize) -> &String {
        &self.known.study.campaign.points[k].id
    }

    /// The most probable parameters of the model.
    pub(in crate::run) fn values(&self) -> &[f64] {
        &self.posterior.gaussian.mean[..self.assembly.parameters().len()]
    }
}
