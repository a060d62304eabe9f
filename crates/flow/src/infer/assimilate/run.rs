//! One run from record to numbers, by any of the methods.

use super::ambient::smooth_ambient;
use super::batch::model::Batch;
use super::ensemble::filter::{FilterOptions, Snapshot, Variant, filter};
use super::ensemble::smoother::smooth;
use super::estimate::Estimate;
use super::record::FlowRecord;
use crate::apparatus::geometry::TubeRig;
use crate::error::FlowError;
use crate::infer::health::FlowHealth;
use crate::infer::report::{
    AssimilationMethod, NamedStates, PowerReport, RunReport, SnapshotReport, UnknownReport,
};
use crate::infer::scores::physical;
use crate::tube::closures::Closures;
use crate::tube::parameters::{UNKNOWNS, unknowns};
use crate::tube::pipe::Pipe;
use rijke_inference::{Parameter, ensemble::Smoother};
use rijke_numerics::Streams;

/// Assimilates one run, and evaluates the base state at every power of its record. The operating points are
/// named as in the campaign of the paper: `H180-25` for 180 W at 0.25 m.
///
/// # Errors
/// Those of the method.
pub fn assimilate(
    rig: &TubeRig,
    closures: &Closures,
    heater: f64,
    record: &FlowRecord,
    method: AssimilationMethod,
    streams: &Streams,
) -> Result<(RunReport, NamedStates), FlowError> {
    let pipe = Pipe::new(rig, closures, heater, 1)?;
    let mut history = Vec::new();
    let (mut innovation_chi_squared, mut effective_rank, mut failed_members) = (None, None, 0);
    let estimate = match method {
        AssimilationMethod::Batch => Batch::new(&pipe, record, BIN)?.fit()?,
        AssimilationMethod::Smoother => {
            smooth(&Batch::new(&pipe, record, BIN)?, 100, &Smoother::default(), streams)?
        }
        AssimilationMethod::Paper | AssimilationMethod::SquareRoot => {
            let variant =
                if method == AssimilationMethod::Paper { Variant::Paper } else { Variant::SquareRoot };
            let run = filter(&pipe, record, &FilterOptions { variant, ..FilterOptions::default() }, streams)?;
            history = run.history.iter().map(SnapshotReport::new).collect::<Result<_, _>>()?;
            innovation_chi_squared = Some(run.innovations.chi_squared_per_datum());
            (effective_rank, failed_members) = (Some(run.effective_rank), run.failed);
            run.estimate
        }
    };
    let sd = |k: usize| estimate.covariance[(k, k)].max(0.0).sqrt();
    let list = unknowns();
    let report = |(k, p): (usize, &Parameter)| UnknownReport::new(p, estimate.mean[k], sd(k));
    let unknowns = list.iter().enumerate().map(report).collect::<Result<_, FlowError>>()?;
    let warnings = estimate.health.as_ref().map(FlowHealth::warnings).unwrap_or_default();
    let (powers, states) = stages(&pipe, record, &estimate)?;
    let health = estimate.health.clone();
    let report = RunReport {
        settling: Vec::new(),
        heater_m: heater,
        method: Some(method),
        health,
        warnings,
        unknowns,
        powers,
        history,
        innovation_chi_squared,
        failed_members,
        effective_rank,
    };
    Ok((report, states))
}

/// Samples per average: the ambient temperature and the walls hardly move in 2.5 min, and the fit has ten
/// times fewer data.
const BIN: usize = 10;

fn stages(
    pipe: &Pipe,
    record: &FlowRecord,
    estimate: &Estimate,
) -> Result<(Vec<PowerReport>, NamedStates), FlowError> {
    let ambient = smooth_ambient(record).temperature;
    let last =
        |i: &usize| record.samples.get(i + 1).is_none_or(|next| next.power != record.samples[*i].power);
    let conditions: Vec<(f64, f64)> =
        (0..record.samples.len()).filter(last).map(|i| (record.samples[i].power, ambient[i])).collect();
    let bases = estimate.base_states(pipe, &conditions)?;
    let (mut powers, mut states) = (Vec::new(), Vec::new());
    for ((power, ambient), mut base) in conditions.into_iter().zip(bases) {
        // The scores are those of this heater position only.
        base.errors.iter_mut().for_each(|e| e.cause = format!("heater at {} m: {}", pipe.heater(), e.cause));
        let id = format!("H{power}-{:02}", (pipe.heater() * 100.0).round());
        powers.push(PowerReport::new(id.clone(), power, ambient, &base, Vec::new()));
        states.push((id, base));
    }
    Ok((powers, states))
}

impl SnapshotReport {
    /// From a snapshot of scores.
    ///
    /// # Errors
    /// [`FlowError::Prior`].
    pub fn new(s: &Snapshot) -> Result<Self, FlowError> {
        let list = unknowns();
        let at = |k: usize, sds: f64| physical(&list[k], s.mean[k] + sds * s.spread[k]);
        Ok(Self {
            time: s.time,
            power: s.power,
            value: (0..UNKNOWNS).map(|k| at(k, 0.0)).collect::<Result<_, _>>()?,
            band: (0..UNKNOWNS).map(|k| Ok([at(k, -2.0)?, at(k, 2.0)?])).collect::<Result<_, FlowError>>()?,
            heater_velocity: s.heater_velocity,
            innovation_chi_squared: s.innovation_chi_squared,
        })
    }
}
