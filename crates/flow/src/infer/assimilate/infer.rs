//! All runs of a record over time; and records made by the model itself.

use super::{AssimilationMethod, NamedStates, Records, RunReport, Twin, TwinOptions, assimilate, staircase};
use crate::apparatus::geometry::TubeRig;
use crate::error::FlowError;
use crate::tube::closures::Closures;
use crate::tube::parameters::UNKNOWNS;
use crate::tube::pipe::Pipe;
use rayon::prelude::*;
use rijke_numerics::{InOrder, Streams};
use rijke_rig::DataKind;

/// What a record over time tells.
#[derive(Clone, Debug)]
pub struct OverTime {
    /// A report for each place of the heater.
    pub runs: Vec<RunReport>,
    /// The base states.
    pub states: NamedStates,
    /// The batch fits of the same runs, if they were asked for.
    pub batch: Vec<RunReport>,
}

/// Every run of a record; `batch`: beside them the batch fits. `done` is called after each.
///
/// # Errors
/// Those of [`assimilate`].
pub fn infer(
    records: &Records,
    closures: &Closures,
    method: AssimilationMethod,
    seed: u64,
    batch: bool,
    done: &(dyn Fn() + Sync),
) -> Result<OverTime, FlowError> {
    let run = |method: AssimilationMethod, (at, record): &(f64, _)| {
        assimilate(&records.rig, closures, *at, record, method, &Streams::new(seed))
    };
    let one = |record| {
        let fit = run(method, record)?;
        let beside = batch.then(|| run(AssimilationMethod::Batch, record)).transpose()?;
        done();
        Ok((fit, beside.map(|(report, _)| report)))
    };
    let fits = records.runs.par_iter().map(one).in_order::<Result<Vec<_>, FlowError>>()?;
    let (fits, batch): (Vec<_>, Vec<_>) = fits.into_iter().unzip();
    let (runs, states): (Vec<RunReport>, Vec<NamedStates>) = fits.into_iter().unzip();
    let states = states.into_iter().flatten().collect();
    Ok(OverTime { runs, states, batch: batch.into_iter().flatten().collect() })
}

/// A virtual record: the model itself at the centre of its priors, with noise, for the paper's staircase of
/// powers, with the heater at each of `places` (m).
///
/// # Errors
/// Those of [`Pipe::new`] and [`Twin::new`].
pub fn twins(closures: &Closures, places: &[f64], seed: u64) -> Result<Records, FlowError> {
    let rig = TubeRig::juniper_yoko_2022();
    let powers = staircase(&[0.0, 7.0, 15.0, 30.0, 50.0, 80.0, 130.0, 180.0], 250);
    let options = TwinOptions { powers, ..TwinOptions::default() };
    let record = |at: &f64| {
        let pipe = Pipe::new(&rig, closures, *at, 1)?;
        let scores = vec![0.0; UNKNOWNS + pipe.microphones().count()];
        Ok((*at, Twin::new(&pipe, &options, &Streams::new(seed), Some(&scores))?.record))
    };
    let runs = places.par_iter().map(record).in_order::<Result<Vec<_>, FlowError>>()?;
    Ok(Records { kind: DataKind::Virtual, rig: rig.clone(), runs })
}
