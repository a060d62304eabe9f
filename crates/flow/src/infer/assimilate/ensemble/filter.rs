//! The ensemble Kalman filter, click by click.

use super::members::{GROUP, Layout, Members};
use crate::error::FlowError;
use crate::infer::assimilate::estimate::Estimate;
use crate::infer::assimilate::record::FlowRecord;
use crate::tube::parameters::{UNKNOWNS, unknowns};
use crate::tube::pipe::Pipe;
use rand_distr::{Distribution, StandardNormal};
use rijke_inference::Parameter;
use rijke_inference::ensemble::{
    Diagnostics, Ensemble, EnsembleData, NoiseCovariance, Scheme, effective_rank, orthogonal_forcing,
};
use rijke_numerics::{Matrix, Streams};

/// Which filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variant {
    /// As the paper describes: perturbed observations at every click, plain random forcing.
    Paper,
    /// Symmetric square root, forcing orthogonal to the anomalies of everything else, parameters frozen
    /// without power.
    SquareRoot,
}

/// How to filter.
#[derive(Clone, Debug, PartialEq)]
pub struct FilterOptions {
    /// Which filter.
    pub variant: Variant,
    /// Members; the paper takes 100.
    pub members: usize,
    /// Keep a snapshot every so many samples; zero counts as one.
    pub every: usize,
}

impl Default for FilterOptions {
    fn default() -> Self {
        Self { variant: Variant::Paper, members: 100, every: 25 }
    }
}

/// The scores at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// Time, s.
    pub time: f64,
    /// Power, W.
    pub power: f64,
    /// Mean of the scores.
    pub mean: Vec<f64>,
    /// Spread of the scores.
    pub spread: Vec<f64>,
    /// Mean and spread of the velocity at the heater, m/s.
    pub heater_velocity: [f64; 2],
    /// Chi-squared of the innovations since the last snapshot, per datum; 1 is expected.
    pub innovation_chi_squared: f64,
}

/// What a filter returns.
#[derive(Clone, Debug)]
pub struct FilterRun {
    /// The scores at the end.
    pub estimate: Estimate,
    /// The scores on the way.
    pub history: Vec<Snapshot>,
    /// Innovations of the whole run.
    pub innovations: Diagnostics,
    /// Independent directions left among the scores at the end.
    pub effective_rank: f64,
    /// Members that failed and were replaced.
    pub failed: usize,
}

/// Assimilates a record sample by sample: arrival times (or what else the sensors measure), ambient
/// temperature and power. State and parameters together; ambient temperature is a random walk whose forcing
/// is the only noise of the model. A member fails if its gas finds no mass flow, or if a wall or the gas
/// leaves the temperatures at which the properties of air hold; it is counted, and replaced as
/// [`Ensemble::forecast`] says.
///
/// # Errors
/// [`FlowError::Ensemble`] if most members fail, and those of the model.
pub fn filter(
    pipe: &Pipe,
    record: &FlowRecord,
    options: &FilterOptions,
    streams: &Streams,
) -> Result<FilterRun, FlowError> {
    let priors = unknowns();
    let biased: Vec<(usize, f64)> = record.biased().collect();
    let layout = Layout { scores: UNKNOWNS + biased.len(), walls: pipe.size() };
    let mut stream = streams.stream("flow/filter");
    let (mut ensemble, members) = Members::draw(pipe, record, &priors, layout, options.members, &mut stream)?;
    let walk = record.ambient_drift.powi(2) * record.interval;
    let noise = NoiseCovariance::Independent(
        record.sensors.iter().map(|s| s.sd.powi(2)).chain([record.ambient_sd.powi(2)]).collect(),
    );
    let scheme = if options.variant == Variant::Paper { Scheme::Stochastic } else { Scheme::SquareRoot };
    let (mut innovations, mut history) = (Diagnostics::default(), Vec::new());
    let mut recent = Diagnostics::default();
    for (step, sample) in record.samples.iter().enumerate() {
        force(&mut ensemble, &layout, walk, options.variant, &mut stream)?;
        let model = |first: usize, rows: &mut [f64]| members.step(sample.power, first, rows);
        let runs = ensemble.forecast_in_groups(step, &mut stream, GROUP, model)?;
        let predicted =
            Matrix::from_fn(options.members, record.sensors.len() + 1, |i, j| runs[i].readings[j]);
        let measured: Vec<f64> = sample.readings.iter().copied().chain([sample.ambient]).collect();
        let observed = EnsembleData { predicted: &predicted, measured: &measured, noise: &noise };
        let frozen = options.variant == Variant::SquareRoot && sample.power == 0.0;
        let before = frozen.then(|| ensemble.members().clone());
        let innovation = ensemble.analyse(&observed, scheme, &mut stream)?;
        innovations.record(&innovation);
        recent.record(&innovation);
        if let Some(before) = before {
            // Without power the data say nothing of the flow; chance correlations would shrink its
            // parameters.
            for i in 0..options.members {
                for j in 0..7 {
                    ensemble.members_mut()[(i, j)] = before[(i, j)];
                }
            }
        }
        if (step + 1) % options.every.max(1) == 0 || step + 1 == record.samples.len() {
            let velocity: Vec<f64> = runs.iter().map(|r| r.velocity).collect();
            let time = (step + 1) as f64 * record.interval;
            let innovations = std::mem::take(&mut recent);
            history.push(snapshot(&ensemble, &layout, time, sample.power, &velocity, &innovations));
        }
    }
    finish(&ensemble, &layout, &priors, &biased, innovations, history)
}

/// Random walk of the ambient temperature.
fn force(
    ensemble: &mut Ensemble,
    layout: &Layout,
    variance: f64,
    variant: Variant,
    stream: &mut rijke_numerics::Stream,
) -> Result<(), FlowError> {
    let members = ensemble.size();
    let drawn = if variant == Variant::Paper {
        let mut draws = Matrix::zeros(members, 1);
        draws.as_mut_slice().iter_mut().for_each(|v| {
            let n: f64 = StandardNormal.sample(stream);
            *v = variance.sqrt() * n;
        });
        draws
    } else {
        // Orthogonal to scores, ambient temperature and released power; the walls follow these.
        let anomalies = ensemble.anomalies();
        let kept = layout.wall();
        let against = Matrix::from_fn(members, kept, |i, j| anomalies[(i, j)]);
        orthogonal_forcing(&against, &[variance], 1e-8, stream)?
    };
    let ambient = layout.ambient();
    for i in 0..members {
        ensemble.members_mut()[(i, ambient)] += drawn[(i, 0)];
    }
    Ok(())
}

fn snapshot(
    ensemble: &Ensemble,
    layout: &Layout,
    time: f64,
    power: f64,
    velocity: &[f64],
    innovations: &Diagnostics,
) -> Snapshot {
    let (mean, spread) = (ensemble.mean(), ensemble.spread());
    let n = velocity.len() as f64;
    let centre = velocity.iter().sum::<f64>() / n;
    let variance = velocity.iter().map(|v| (v - centre).powi(2)).sum::<f64>() / (n - 1.0);
    Snapshot {
        time,
        power,
        mean: mean[..layout.scores].to_vec(),
        spread: spread[..layout.scores].to_vec(),
        heater_velocity: [centre, variance.sqrt()],
        innovation_chi_squared: innovations.chi_squared_per_datum(),
    }
}

fn finish(
    ensemble: &Ensemble,
    layout: &Layout,
    priors: &[Parameter; UNKNOWNS],
    biased: &[(usize, f64)],
    innovations: Diagnostics,
    history: Vec<Snapshot>,
) -> Result<FilterRun, FlowError> {
    let keep: Vec<usize> = (0..layout.scores).collect();
    let covariance = ensemble.covariance().select(&keep);
    let names = priors.iter().map(|p| p.name.clone());
    let names = names.chain(biased.iter().map(|(i, _)| format!("bias_{i}"))).collect();
    let mean = ensemble.mean()[..layout.scores].to_vec();
    let rank = effective_rank(&covariance)?;
    let estimate = Estimate::new(priors, names, mean, covariance)?;
    Ok(FilterRun { estimate, history, innovations, effective_rank: rank, failed: ensemble.failures().len() })
}
