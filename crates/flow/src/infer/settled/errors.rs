//! Base states with their errors, from a joint posterior.

use super::fit::JointFit;
use super::joint::Arrow;
use super::of_run::Settled;
use super::run::State;
use super::unknowns::FIXED;
use crate::base::state::{BaseState, ErrorComponent};
use crate::error::FlowError;
use crate::infer::report::NamedStates;
use rijke_numerics::{Matrix, dot, principal_directions, symmetric_eigen};

/// Share of the variance that causes carry, of the common ones and of a run's own.
const ENOUGH: f64 = 0.99999;

impl JointFit<'_> {
    /// The base state of every operating point, run by run. The errors are named causes that the points
    /// share.
    ///
    /// The covariance of all scores is cut into rank-one parts, each a cause: first, for every day, the part
    /// C e e' C/(e' C e) that goes with the error of its thermometer (the only one that a cold state has).
    /// Given all days, the scores that runs share are the only reason why runs go together: their principal
    /// directions, as seen by the relative changes of all base states, are causes of all runs; those of what
    /// is left of each run are causes of its own. Each time the largest go first, until they carry 99.999 %
    /// of the variance. States that were read come first: a state that is only foreseen adds causes of its
    /// own, and changes none of theirs.
    ///
    /// # Errors
    /// [`FlowError::Dense`] if an eigenvalue iteration fails.
    pub fn base_states(&self) -> Result<NamedStates, FlowError> {
        let mut own: Vec<Vec<Cause>> = Vec::new();
        let mut without_days = Vec::new();
        for run in &self.runs {
            let (days, mut left, mut causes) = (run.run.days(), run.covariance.clone(), Vec::new());
            for (d, day) in days.iter().enumerate() {
                let (k, n) = (FIXED + d, left.rows());
                let variance = left[(k, k)];
                if variance > 0.0 {
                    let part: Vec<f64> = (0..n).map(|i| left[(i, k)] / variance.sqrt()).collect();
                    left = Matrix::from_fn(n, n, |i, j| left[(i, j)] - part[i] * part[j]);
                    let name = format!("ambient temperature on {day}, heater at {} m", run.run.heater);
                    causes.push(Cause { name, moves: run.base_slopes.times(&part) });
                }
            }
            own.push(causes);
            let day = |k: usize| (FIXED..FIXED + days.len()).contains(&k);
            without_days.push(Matrix::from_fn(left.rows(), left.rows(), |i, j| {
                if day(i) || day(j) { 0.0 } else { run.information[(i, j)] }
            }));
        }
        let given = Arrow::new(without_days.iter(), 0.0)?;
        let mut gram = [Matrix::zeros(FIXED, FIXED), Matrix::zeros(FIXED, FIXED)];
        let mut along = Vec::new();
        for (p, run) in self.runs.iter().enumerate() {
            let (follow, mut covariance) = given.of(p);
            let days = FIXED..FIXED + run.run.days().len();
            days.for_each(|k| covariance[(k, k)] = 0.0);
            let relative = run.relative_slopes();
            let square = |m: &Matrix| m.transpose().product(m);
            let parts = relative.map(|relative| {
                let seen = relative.product(&follow);
                (square(&seen), square(&relative))
            });
            let mine = principal(&covariance, [&parts[0].1, &parts[1].1])?;
            gram = [gram[0].plus(1.0, &parts[0].0), gram[1].plus(1.0, &parts[1].0)];
            own[p].extend(mine.iter().enumerate().map(|(n, part)| {
                let name = format!("heater at {} m: base flow {}", run.run.heater, n + 1);
                Cause { name, moves: run.base_slopes.times(part) }
            }));
            along.push(run.base_slopes.product(&follow));
        }
        let common = principal(&given.shared, [&gram[0], &gram[1]])?;
        let mut list = NamedStates::new();
        for ((run, own), along) in self.runs.iter().zip(&own).zip(&along) {
            let shared = common
                .iter()
                .enumerate()
                .map(|(n, part)| Cause { name: format!("base flow {}", n + 1), moves: along.times(part) });
            let causes: Vec<Cause> = shared.chain(own.iter().cloned()).collect();
            let mut first = 0;
            for (state, predicted) in run.run.states.iter().zip(&run.predicted) {
                let rows = first..first + predicted.base.len();
                first = rows.end;
                let errors = causes.iter().filter_map(|Cause { name, moves }| {
                    let moves = &moves[rows.clone()];
                    moves.iter().any(|m| *m != 0.0).then(|| ErrorComponent {
                        cause: name.clone(),
                        mass_flux: moves[0],
                        heater_velocity: moves[1],
                        temperature: moves[2..].to_vec(),
                    })
                });
                let base = BaseState {
                    gas: run.pipe.gas.clone(),
                    pressure: run.pipe.air.pressure,
                    mass_flux: predicted.base[0],
                    heater_velocity: predicted.base[1],
                    places: run.pipe.faces.clone(),
                    temperature: predicted.base[2..].to_vec(),
                    errors: errors.collect(),
                };
                list.push((state.id.clone(), base.checked()?));
            }
        }
        Ok(list)
    }
}

impl Settled<'_> {
    /// Relative changes of the base vectors per score: of the states that were read or passed, and of all.
    fn relative_slopes(&self) -> [Matrix; 2] {
        let foreseen = |state: &State| state.sensors.is_empty() && state.moment.is_none();
        let all: Vec<(f64, bool)> = self
            .run
            .states
            .iter()
            .zip(&self.predicted)
            .flat_map(|(state, p)| p.base.iter().map(|value| (*value, foreseen(state))))
            .collect();
        [false, true].map(|with_foreseen| {
            // Still gas has no scale of its own.
            let relative = |r: usize, i: usize| match all[r] {
                (_, true) if !with_foreseen => 0.0,
                (0.0, _) => 0.0,
                (base, _) => self.base_slopes[(r, i)] / base,
            };
            Matrix::from_fn(all.len(), self.base_slopes.columns(), relative)
        })
    }
}

/// Principal directions of the covariance `c` where a change d has the size d' G d, until they carry enough
/// of the variance: first by the first of the matrices G, then those of what is left by the second.
fn principal(c: &Matrix, grams: [&Matrix; 2]) -> Result<Vec<Vec<f64>>, FlowError> {
    let size = |c: &Matrix, gram: &Matrix| (0..c.rows()).map(|i| dot(c.row(i), gram.row(i))).sum::<f64>();
    let (mut left, mut list) = (c.clone(), Vec::<Vec<f64>>::new());
    for gram in grams {
        let found = largest(&left, gram, (1.0 - ENOUGH) * size(c, gram))?;
        for part in &found {
            left = Matrix::from_fn(c.rows(), c.rows(), |i, j| left[(i, j)] - part[i] * part[j]);
        }
        list.extend(found);
    }
    Ok(list)
}

/// The largest principal directions of the covariance `c`, where a change d has the size d'`gram` d, until no
/// more than `rest` of the variance is left.
fn largest(c: &Matrix, gram: &Matrix, rest: f64) -> Result<Vec<Vec<f64>>, FlowError> {
    // With G = E E', the directions are the eigenvectors v of E'C E, and the rank-one part of C that belongs
    // to one of them is C E v (v'E'C E v)^{-1/2}.
    let (values, vectors) = symmetric_eigen(gram)?;
    let top = values.iter().copied().fold(0.0, f64::max);
    let seen: Vec<usize> = (0..c.rows()).filter(|&k| values[k] > 1e-12 * top).collect();
    let root = Matrix::from_fn(c.rows(), seen.len(), |i, k| vectors[(i, seen[k])] * values[seen[k]].sqrt());
    let carried = c.product(&root);
    let directions = principal_directions(&root.transpose().product(&carried))?;
    let (mut left, mut list) = (directions.iter().map(|(value, _)| value).sum::<f64>(), Vec::new());
    for (value, along) in directions {
        if value <= 0.0 || left < rest {
            break;
        }
        left -= value;
        let direction: Vec<f64> = along.iter().map(|a| a / value.sqrt()).collect();
        list.push(carried.times(&direction));
    }
    Ok(list)
}

/// A rank-one part of a covariance: its name, and what it does to the base vectors of a run.
#[derive(Clone)]
struct Cause {
    name: String,
    moves: Vec<f64>,
}
