//! The ensemble Kalman filter, click by click.

use super::record::observe;
use super::{Estimate, Record, unknowns_from};
use crate::{FlowError, Pipe, Transient, UNKNOWNS, Unknowns, unknowns};
use rand_distr::{Distribution, StandardNormal};
use rijke_inference::Parameter;
use rijke_inference::ensemble::{
    Diagnostics, Ensemble, Noise, Observed, Options, Scheme, effective_rank, orthogonal_forcing,
};
use rijke_numerics::{Matrix, Streams};

/// Which filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variant {
    /// As the paper describes: perturbed observations at every click, plain random forcing.
    Paper,
    /// Symmetric square root, forcing orthogonal to the anomalies of everything else, parameters frozen without power.
    SquareRoot,
}

/// How to filter.
#[derive(Clone, Debug, PartialEq)]
pub struct FilterOptions {
    /// Which filter.
    pub variant: Variant,
    /// Members; the paper takes 100.
    pub members: usize,
    /// Keep a snapshot every so many samples.
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

/// Columns of the filter's state: scores, ambient temperature, released power, walls.
struct Layout {
    scores: usize,
    walls: usize,
}

impl Layout {
    fn ambient(&self) -> usize {
        self.scores
    }
    fn released(&self) -> usize {
        self.scores + 1
    }
    fn wall(&self) -> usize {
        self.scores + 2
    }
    fn columns(&self) -> usize {
        self.scores + 2 + self.walls
    }
}

/// Assimilates a record sample by sample: arrival times (or what else the sensors measure), ambient temperature and
/// power. State and parameters together; ambient temperature is a random walk whose forcing is the only noise of the
/// model. A member that fails is replaced as [`Ensemble::forecast`] says.
///
/// # Errors
/// [`FlowError::Ensemble`] if most members fail, and those of the model.
pub fn filter(
    pipe: &Pipe,
    record: &Record,
    options: &FilterOptions,
    streams: &Streams,
) -> Result<FilterRun, FlowError> {
    let priors = unknowns();
    let biased: Vec<(usize, f64)> = record.biased().collect();
    let layout = Layout { scores: UNKNOWNS + biased.len(), walls: pipe.size() };
    let mut stream = streams.stream("flow/filter");
    let first = record.samples.first().map_or(f64::NAN, |s| s.ambient);
    let (mut ensemble, mut states) =
        start(pipe, record, &priors, &layout, options.members, first, &mut stream)?;
    let implicit = pipe.implicit(record.interval);
    let walk = record.ambient_drift.powi(2) * record.interval;
    let noise = Noise::Independent(
        record.sensors.iter().map(|s| s.sd.powi(2)).chain([record.ambient_sd.powi(2)]).collect(),
    );
    let scheme = if options.variant == Variant::Paper { Scheme::Stochastic } else { Scheme::SquareRoot };
    let analysis = Options { scheme, ..Options::default() };
    let (mut innovations, mut history) = (Diagnostics::default(), Vec::new());
    let mut recent = Diagnostics::default();
    for (step, sample) in record.samples.iter().enumerate() {
        force(&mut ensemble, &layout, walk, options.variant, &mut stream)?;
        let shared: Vec<std::sync::Mutex<&mut Transient<f64>>> =
            states.iter_mut().map(std::sync::Mutex::new).collect();
        let runs = ensemble.forecast(step, &mut stream, |member, row| {
            let u = member_unknowns(&priors, row)?;
            let mut guard = shared[member].lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            let state = &mut **guard;
            advance(pipe, &implicit, &layout, &u, sample.power, row, state)?;
            let (mut times, mut seen) = (Vec::new(), Vec::new());
            observe(pipe, &record.sensors, &state.gas, &u, &mut times, &mut seen);
            for (k, (sensor, sd)) in biased.iter().enumerate() {
                seen[*sensor] += row[UNKNOWNS + k] * sd;
            }
            seen.push(row[layout.ambient()] - u.ambient_offset);
            Ok::<_, FlowError>((seen, pipe.heater_velocity(&state.gas)))
        })?;
        let predicted = Matrix::from_fn(options.members, record.sensors.len() + 1, |i, j| runs[i].0[j]);
        let measured: Vec<f64> = sample.readings.iter().copied().chain([sample.ambient]).collect();
        let observed = Observed { predicted: &predicted, measured: &measured, noise: &noise };
        let frozen = options.variant == Variant::SquareRoot && sample.power == 0.0;
        let before = frozen.then(|| ensemble.members().clone());
        let innovation = ensemble.analyse(&observed, &analysis, &mut stream)?;
        innovations.record(&innovation);
        recent.record(&innovation);
        if let Some(before) = before {
            // Without power the data say nothing of the flow; chance correlations would shrink its parameters.
            for i in 0..options.members {
                for j in 0..7 {
                    ensemble.members_mut()[(i, j)] = before[(i, j)];
                }
            }
        }
        if (step + 1) % options.every == 0 || step + 1 == record.samples.len() {
            let velocity: Vec<f64> = runs.iter().map(|r| r.1).collect();
            let time = (step + 1) as f64 * record.interval;
            let innovations = std::mem::take(&mut recent);
            history.push(snapshot(&ensemble, &layout, time, sample.power, &velocity, &innovations));
        }
    }
    finish(&ensemble, &layout, &priors, &biased, innovations, history)
}

fn start(
    pipe: &Pipe,
    record: &Record,
    priors: &[Parameter; UNKNOWNS],
    layout: &Layout,
    members: usize,
    first: f64,
    stream: &mut rijke_numerics::Stream,
) -> Result<(Ensemble, Vec<Transient<f64>>), FlowError> {
    let mut normal = || -> f64 { StandardNormal.sample(&mut *stream) };
    let mut rows = Matrix::zeros(members, layout.columns());
    let mut states = Vec::with_capacity(members);
    for i in 0..members {
        for j in 0..layout.scores {
            rows[(i, j)] = normal();
        }
        let row: Vec<f64> = rows.row(i).to_vec();
        let u = member_unknowns(priors, &row)?;
        // The tube and the room start at the same temperature, known from one reading.
        let indicated = first + record.ambient_sd * normal();
        let state = Transient::cold(pipe, &u, indicated)?;
        rows[(i, layout.ambient())] = state.ambient;
        for k in 0..layout.walls {
            rows[(i, layout.wall() + k)] = state.ambient;
        }
        states.push(state);
    }
    Ok((Ensemble::new(rows)?, states))
}

fn member_unknowns(priors: &[Parameter; UNKNOWNS], row: &[f64]) -> Result<Unknowns, FlowError> {
    unknowns_from(priors, &row[..UNKNOWNS])
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

/// One step of one member: the row is written into the state, the state stepped, and read back.
fn advance(
    pipe: &Pipe,
    implicit: &crate::Implicit,
    layout: &Layout,
    u: &Unknowns,
    power: f64,
    row: &mut [f64],
    state: &mut Transient<f64>,
) -> Result<(), FlowError> {
    state.wall.copy_from_slice(&row[layout.wall()..]);
    state.released = row[layout.released()];
    let ambient = row[layout.ambient()];
    state.ambient = ambient;
    state.refresh(pipe, u, TOLERANCE)?;
    state.step(pipe, implicit, u, power, ambient - u.ambient_offset, TOLERANCE)?;
    row[layout.wall()..].copy_from_slice(&state.wall);
    row[layout.released()] = state.released;
    Ok(())
}

/// Tolerance of the mass flow in ln(buoyancy/losses): 4e-5 of U_h, 0.01 us in an arrival time.
const TOLERANCE: f64 = 1e-4;

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
