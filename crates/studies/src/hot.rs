//! The hot operating points, ready for inference: pings, base flow, and what the cold stages know.

use crate::competition::{gauss_newton, measured};
use crate::prongs::provenance;
use crate::setting;
use crate::{ColdStage, HotPoint, Provenance, StudyError};
use rijke_inference::NoiseMode;
use rijke_model::{BaseStates, Conditions, Knowledge, ModelError, Noise, Observed, Training, Varying};
use rijke_rig::{Observations, PointObservations, Rig};

/// The hot points of a campaign with their base flow, and the cold model.
#[derive(Clone, Debug)]
pub struct Hot {
    pub(crate) rig: Rig,
    pub(crate) provenance: Provenance,
    /// Ascending power, then ascending position; pings as they are heard through the channels that the cold stages found.
    pub(crate) points: Vec<Observed>,
    pub(crate) measured: Vec<HotPoint>,
    pub(crate) cold: ColdStage,
}

impl Hot {
    /// All points with power of `observations` that have an accepted ping, with the base flow that `states` has of them.
    ///
    /// # Errors
    /// [`StudyError::NoPoint`] without hot points; [`StudyError::NoBaseState`].
    pub fn new(
        observations: &Observations,
        states: &BaseStates,
        cold: ColdStage,
    ) -> Result<Self, StudyError> {
        let mut hot: Vec<&PointObservations> =
            observations.points.iter().filter(|p| p.point.power > 0.0 && p.ping.is_some()).collect();
        if hot.len() < 2 {
            return Err(StudyError::NoPoint { need: "with the heater switched on, at two points".into() });
        }
        let place = |p: &PointObservations| p.point.position.unwrap_or(0.0);
        hot.sort_by(|a, b| a.point.power.total_cmp(&b.point.power).then(place(a).total_cmp(&place(b))));
        let points = hot
            .into_iter()
            .map(|p| of_point(p, states, &cold.stage.knowledge))
            .collect::<Result<Vec<_>, _>>()?;
        let hot_point = |o: &Observed| HotPoint {
            measured: measured(o),
            power_w: o.conditions.point.power,
            heater_velocity: o.conditions.base.heater_velocity,
            heater_velocity_sd: o.conditions.base.heater_velocity_sd(),
        };
        Ok(Self {
            rig: observations.rig.clone(),
            provenance: provenance(observations, &points),
            measured: points.iter().map(hot_point).collect(),
            points,
            cold,
        })
    }

    /// Noise floats, as in the paper. So does what all powers at one position share, about the misfit of the cold points: each of those
    /// was a setting of its own, so that their misfit is what settings differ by, and what else there is.
    pub(crate) fn noise(&self) -> Noise {
        let setting = [0, 1].map(|k| NoiseMode::Inferred { median: self.cold.noise[k], ln_sd: 1.0 });
        Noise { setting, ..Noise::FLOATED }
    }

    /// And the error of the law of the heat release, the same wherever the heater stands, and a noise of the growth rate about that of the
    /// cold points, which eight points alone would make too small: for what a model predicts. Not for the table, where the first would take
    /// from every law the blame for its dependence on the power.
    pub(crate) fn honest_noise(&self) -> Noise {
        let growth_rate = NoiseMode::Inferred { median: self.cold.noise[0], ln_sd: 1.0 };
        Noise { heat_release: LAW_ERROR, growth_rate, ..self.noise() }
    }

    /// What the cold stages found of the components that are not the heat release.
    pub(crate) fn known(&self) -> Vec<Knowledge> {
        vec![self.cold.stage.knowledge.clone()]
    }

    /// The ends, which scatter between settings as the cold stages found.
    pub(crate) fn varying(&self) -> Vec<Varying> {
        setting::ends_as_found(self.cold.ends_sd)
    }

    pub(crate) fn training(&self, noise: Noise, known: Vec<Knowledge>) -> Training {
        Training {
            microphones: self.microphones(),
            noise,
            known,
            search: gauss_newton(),
            base_errors: true,
            varying: self.varying(),
            channels: None,
            checks: None,
        }
    }

    pub(crate) fn microphones(&self) -> Vec<usize> {
        (0..self.rig.microphones.positions.len()).collect()
    }
}

/// Relative error of a law of the heat release from power to power. King's law and the correlation of Collis & Williams (J. Fluid Mech. 6,
/// 1959, 357), which hot-wire anemometers use, differ by 2 % in how d ln Nu/d ln u grows over the Reynolds numbers of the wire.
const LAW_ERROR: f64 = 0.02;

fn of_point(
    point: &PointObservations,
    states: &BaseStates,
    cold: &Knowledge,
) -> Result<Observed, StudyError> {
    let id = &point.point.id;
    let ping = point
        .ping
        .as_ref()
        .map(|ping| cold.without_channels(ping))
        .ok_or_else(|| ModelError::NoPing { point: id.clone() })?;
    let base = states.points.get(id).ok_or_else(|| StudyError::NoBaseState { point: id.clone() })?.clone();
    let ambient = base.temperature[0];
    Ok(Observed { conditions: Conditions { point: point.point.clone(), base, ambient }, ping })
}
