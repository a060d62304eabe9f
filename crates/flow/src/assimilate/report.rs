//! One run from record to numbers: what `rijke flow` writes and figures are drawn from.

use super::{
    Batch, Estimate, FilterOptions, Health, Record, Snapshot, Variant, Warning, filter, physical, smooth,
    smooth_ambient,
};
use crate::{BaseState, Closures, FlowError, Pipe, UNKNOWNS, unknowns};
use rijke_inference::ensemble::Smoother;
use rijke_numerics::Streams;
use rijke_rig::Rig;
use serde::{Deserialize, Serialize};

/// How to assimilate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
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
    /// The method.
    pub method: Method,
    /// What the method says of its own result; none for filters and smoother.
    pub health: Option<Health>,
    /// Reasons not to trust it.
    pub warnings: Vec<Warning>,
    /// The unknowns.
    pub unknowns: Vec<UnknownReport>,
    /// One entry per power, in the order of the record.
    pub powers: Vec<PowerReport>,
    /// Scores against time, for a filter.
    pub history: Vec<SnapshotReport>,
    /// Chi-squared of a filter's innovations per datum. Near 1 proves nothing.
    pub innovation_chi_squared: Option<f64>,
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
    /// Everything acoustics needs, with all error components.
    pub base_state: BaseState,
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
}

/// Assimilates one run, and evaluates the base state at every power of its record.
///
/// # Errors
/// Those of the method.
pub fn assimilate(
    rig: &Rig,
    closures: &Closures,
    heater: f64,
    record: &Record,
    method: Method,
    streams: &Streams,
) -> Result<RunReport, FlowError> {
    let pipe = Pipe::new(rig, closures, heater, 1)?;
    let mut history = Vec::new();
    let mut innovation_chi_squared = None;
    let estimate = match method {
        Method::Batch => Batch::new(&pipe, record, BIN).fit()?,
        Method::Smoother => smooth(&Batch::new(&pipe, record, BIN), 100, &Smoother::default(), streams)?,
        Method::Paper | Method::SquareRoot => {
            let variant = if method == Method::Paper { Variant::Paper } else { Variant::SquareRoot };
            let run = filter(&pipe, record, &FilterOptions { variant, ..FilterOptions::default() }, streams)?;
            history = run.history.iter().map(snapshot).collect::<Result<_, _>>()?;
            innovation_chi_squared = Some(run.innovations.chi_squared_per_datum());
            run.estimate
        }
    };
    let list = unknowns();
    let report = |(k, p): (usize, &rijke_inference::Parameter)| {
        Ok(UnknownReport {
            name: p.name.clone(),
            symbol: p.symbol.clone(),
            unit: p.unit.clone(),
            value: estimate.value(k, 0.0)?,
            low: estimate.value(k, -2.0)?,
            high: estimate.value(k, 2.0)?,
            shrinkage: estimate.covariance[(k, k)].max(0.0).sqrt(),
        })
    };
    let unknowns = list.iter().enumerate().map(report).collect::<Result<_, FlowError>>()?;
    let warnings = estimate.health.as_ref().map(Health::warnings).unwrap_or_default();
    let powers = stages(&pipe, record, &estimate)?;
    let health = estimate.health.clone();
    Ok(RunReport {
        heater_m: heater,
        method,
        health,
        warnings,
        unknowns,
        powers,
        history,
        innovation_chi_squared,
    })
}

/// Samples per average: the ambient temperature and the walls hardly move in 2.5 min, and the fit has ten times fewer
/// data.
const BIN: usize = 10;

fn stages(pipe: &Pipe, record: &Record, estimate: &Estimate) -> Result<Vec<PowerReport>, FlowError> {
    let (ambient, _) = smooth_ambient(record);
    let mut powers = Vec::new();
    for (i, sample) in record.samples.iter().enumerate() {
        if record.samples.get(i + 1).is_some_and(|next| next.power == sample.power) {
            continue;
        }
        let base_state = estimate.base_state(pipe, sample.power, ambient[i])?;
        let covariance = base_state.sound_speed_covariance(&base_state.places);
        let profile = base_state.places.iter().enumerate().map(|(k, &x)| PointReport {
            x,
            temperature: base_state.temperature(x),
            sound_speed: base_state.sound_speed(x),
            sound_speed_sd: covariance[(k, k)].max(0.0).sqrt(),
        });
        powers.push(PowerReport {
            power_w: sample.power,
            ambient_k: ambient[i],
            heater_velocity: base_state.heater_velocity,
            heater_velocity_sd: base_state.heater_velocity_sd(),
            profile: profile.collect(),
            base_state,
        });
    }
    Ok(powers)
}

fn snapshot(s: &Snapshot) -> Result<SnapshotReport, FlowError> {
    let list = unknowns();
    let at = |k: usize, sds: f64| physical(&list[k], s.mean[k] + sds * s.spread[k]);
    Ok(SnapshotReport {
        time: s.time,
        power: s.power,
        value: (0..UNKNOWNS).map(|k| at(k, 0.0)).collect::<Result<_, _>>()?,
        band: (0..UNKNOWNS).map(|k| Ok([at(k, -2.0)?, at(k, 2.0)?])).collect::<Result<_, FlowError>>()?,
        heater_velocity: s.heater_velocity,
    })
}
