//! A fitted run as numbers: what `rijke flow` writes and figures are drawn from.

use super::health::{FlowHealth, FlowWarning};
use super::scores::physical;
use super::sensor::SensorKind;
use crate::base::state::BaseState;
use crate::error::FlowError;
use rijke_inference::Parameter;
use serde::{Deserialize, Serialize};

/// How to assimilate a record over time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum AssimilationMethod {
    /// All clicks at once, Laplace's covariance; the default.
    Batch,
    /// ES-MDA, free of derivatives.
    Smoother,
    /// The filter of the paper: overconfident, for comparison.
    Paper,
    /// The square-root filter with orthogonal forcing: less overconfident.
    SquareRoot,
}

/// The result of one heater position.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RunReport {
    /// Place of the heater, m.
    pub heater_m: f64,
    /// The method; none for the mean readings of settled states ([`crate::settled`]).
    pub method: Option<AssimilationMethod>,
    /// What the method says of its own result; none for filters and smoother. For settled states without
    /// whiteness.
    pub health: Option<FlowHealth>,
    /// Reasons not to trust it.
    pub warnings: Vec<FlowWarning>,
    /// The unknowns.
    pub unknowns: Vec<UnknownReport>,
    /// One entry per power, in the order of the record.
    pub powers: Vec<PowerReport>,
    /// When the flow of each ramp is settled; of a record over time none.
    #[serde(default)]
    pub settling: Vec<SettlingReport>,
    /// Scores against time, for a filter.
    pub history: Vec<SnapshotReport>,
    /// Chi-squared of a filter's innovations per datum. Near 1 proves nothing.
    pub innovation_chi_squared: Option<f64>,
    /// Members of a filter that failed and were replaced by a draw from the others.
    #[serde(default)]
    pub failed_members: usize,
    /// Independent directions left among the scores at the end of a filter, of as many as there are scores.
    #[serde(default)]
    pub effective_rank: Option<f64>,
}

#[cfg(test)]
impl RunReport {
    /// Of nothing.
    pub(crate) fn empty() -> Self {
        Self {
            heater_m: 0.0,
            method: None,
            health: None,
            warnings: Vec::new(),
            unknowns: Vec::new(),
            powers: Vec::new(),
            settling: Vec::new(),
            history: Vec::new(),
            innovation_chi_squared: None,
            failed_members: 0,
            effective_rank: None,
        }
    }
}

/// One unknown.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct UnknownReport {
    /// Name.
    pub name: String,
    /// Symbol.
    pub symbol: String,
    /// Unit.
    pub unit: String,
    /// Two sd below the centre of the prior, through the transform.
    pub prior_low: f64,
    /// Two sd above.
    pub prior_high: f64,
    /// Value at the centre of the posterior.
    pub value: f64,
    /// Two sd below, through the transform.
    pub low: f64,
    /// Two sd above.
    pub high: f64,
    /// Posterior over prior sd of the score; near 1 the data say nothing.
    pub shrinkage: f64,
}

/// The base state at one power.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct PowerReport {
    /// Name of the operating point, by which `base-states.json` knows its state.
    pub point: String,
    /// Indicated power, W.
    pub power_w: f64,
    /// Smoothed ambient temperature at the end of the stage, K.
    pub ambient_k: f64,
    /// Velocity at the heater, m/s.
    pub heater_velocity: f64,
    /// Its sd.
    pub heater_velocity_sd: f64,
    /// Sound speed along the tube, with its sd.
    pub profile: Vec<PointReport>,
    /// Readings against the fit; none for a record over time.
    pub residuals: Vec<ResidualReport>,
}

/// When the flow of a ramp is settled, if its power stays.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SettlingReport {
    /// Name of the ramp.
    pub ramp: String,
    /// The last power in its log, W.
    pub power_w: f64,
    /// Time of the last row of the log, s.
    pub time_s: f64,
    /// How long after that row the flow is within 1 % and 1 K of where it ends, s; none if that takes more
    /// than four hours.
    pub after_s: Option<f64>,
}

/// One reading of a settled state.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ResidualReport {
    /// What was read.
    pub sensor: SensorKind,
    /// The reading, in s, K or m/s.
    pub reading: f64,
    /// The fitted value.
    pub fitted: f64,
    /// Sd of the reading, common errors included.
    pub sd: f64,
}

impl PowerReport {
    pub(crate) fn new(
        point: String,
        power_w: f64,
        ambient_k: f64,
        base: &BaseState,
        residuals: Vec<ResidualReport>,
    ) -> Self {
        let covariance = base.sound_speed_covariance(&base.places);
        let profile = base.places.iter().enumerate().map(|(k, &x)| PointReport {
            x,
            temperature: base.temperature(x),
            sound_speed: base.sound_speed(x),
            sound_speed_sd: covariance[(k, k)].max(0.0).sqrt(),
        });
        Self {
            point,
            power_w,
            ambient_k,
            heater_velocity: base.heater_velocity,
            heater_velocity_sd: base.heater_velocity_sd(),
            profile: profile.collect(),
            residuals,
        }
    }
}

impl UnknownReport {
    /// From a prior and the mean and sd of its normal score.
    pub(crate) fn new(prior: &Parameter, mean: f64, sd: f64) -> Result<Self, FlowError> {
        Ok(Self {
            name: prior.name.clone(),
            symbol: prior.symbol.clone(),
            unit: prior.unit.clone(),
            prior_low: physical(prior, -2.0)?,
            prior_high: physical(prior, 2.0)?,
            value: physical(prior, mean)?,
            low: physical(prior, mean - 2.0 * sd)?,
            high: physical(prior, mean + 2.0 * sd)?,
            shrinkage: sd,
        })
    }
}

/// The gas at one place.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct PointReport {
    /// Place, m.
    pub x: f64,
    /// Temperature, K.
    pub temperature: f64,
    /// Sound speed, m/s.
    pub sound_speed: f64,
    /// Its sd.
    pub sound_speed_sd: f64,
}

/// A filter at one time.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SnapshotReport {
    /// Time, s.
    pub time: f64,
    /// Power, W.
    pub power: f64,
    /// Unknowns at the mean score, in physical units.
    pub value: Vec<f64>,
    /// The same two spreads below and above.
    pub band: Vec<[f64; 2]>,
    /// Mean and spread of the velocity at the heater, m/s.
    pub heater_velocity: [f64; 2],
    /// Chi-squared of the innovations since the entry before, per datum; 1 is expected.
    pub innovation_chi_squared: f64,
}

/// Base states by the names of their operating points.
pub type NamedStates = Vec<(String, BaseState)>;
