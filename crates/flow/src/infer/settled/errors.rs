//! Base states with their errors, from a joint posterior.

use super::fit::Fit;
use super::unknowns::FIXED;
use crate::base::state::{BaseState, ErrorComponent};
use crate::error::FlowError;
use crate::infer::report::NamedStates;
use rijke_numerics::{Matrix, symmetric_eigen};

/// Share of the variance of relative changes that causes common to all runs carry; the rest is cut run by run.
const COMMON: f64 = 0.98;
/// Share of a run's rest that its own causes carry.
const OWN: f64 = 0.9999;

impl Fit<'_> {
    /// The base state of every operating point, run by run. The errors are named causes that the points share.
    ///
    /// The covariance C of all scores is cut into rank-one parts, each a cause: first, for every day, the part C e e' C/(e' C e)
    /// that goes with the error of its thermometer (the only one that a cold state has); then the principal directions of
    /// what is left, as seen by the relative changes of all base states, largest first, until they carry 98 % of the variance.
    /// The last 2 % are cut run by run in the same way: correlations between runs are dropped there, variances are not.
    ///
    /// # Errors
    /// [`FlowError::Dense`] if an eigenvalue iteration fails.
    pub fn base_states(&self) -> Result<NamedStates, FlowError> {
        let slopes: Vec<Matrix> =
            self.runs.iter().zip(&self.turns).map(|(run, turn)| run.base_slopes.product(turn)).collect();
        let mut causes: Vec<Cause> = Vec::new();
        let mut left = self.covariance.clone();
        for (p, (run, turn)) in self.runs.iter().zip(&self.turns).enumerate() {
            for (d, day) in run.run.days().iter().enumerate() {
                let along = left.times(turn.row(FIXED + d));
                let variance = along.iter().zip(turn.row(FIXED + d)).map(|(a, t)| a * t).sum::<f64>();
                if variance > 0.0 {
                    let part: Vec<f64> = along.iter().map(|a| a / variance.sqrt()).collect();
                    remove(&mut left, &part);
                    let name = format!("ambient temperature on {day}, heater at {} m", run.run.heater);
                    causes.push(Cause { name, run: Some(p), part });
                }
            }
        }
        let everywhere: Vec<usize> = (0..self.runs.len()).collect();
        for (n, part) in self.principal(&left, &slopes, &everywhere, COMMON)?.into_iter().enumerate() {
            remove(&mut left, &part);
            causes.push(Cause { name: format!("base flow {}", n + 1), run: None, part });
        }
        for (p, run) in self.runs.iter().enumerate() {
            for (n, part) in self.principal(&left, &slopes, &[p], OWN)?.into_iter().enumerate() {
                let name = format!("heater at {} m: base flow {}", run.run.heater, n + 1);
                causes.push(Cause { name, run: Some(p), part });
            }
        }
        let mut list = NamedStates::new();
        for (p, (run, slopes)) in self.runs.iter().zip(&slopes).enumerate() {
            let mut first = 0;
            for (state, predicted) in run.run.states.iter().zip(&run.predicted) {
                let rows = first..first + predicted.base.len();
                first = rows.end;
                let mine = causes.iter().filter(|c| c.run.is_none_or(|run| run == p));
                let errors = mine.filter_map(|Cause { name, part, .. }| {
                    let moves: Vec<f64> = rows
                        .clone()
                        .map(|r| slopes.row(r).iter().zip(part).map(|(s, p)| s * p).sum())
                        .collect();
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

    /// Principal directions of the covariance `c` as the relative changes of the base states of some runs see them, until
    /// they carry the share `enough` of the variance.
    fn principal(
        &self,
        c: &Matrix,
        slopes: &[Matrix],
        runs: &[usize],
        enough: f64,
    ) -> Result<Vec<Vec<f64>>, FlowError> {
        let size = c.rows();
        let mut gram = Matrix::zeros(size, size);
        for &p in runs {
            let (run, slopes) = (&self.runs[p], &slopes[p]);
            let base: Vec<f64> = run.predicted.iter().flat_map(|p| p.base.iter().copied()).collect();
            // Still gas has no scale of its own.
            let relative = Matrix::from_fn(slopes.rows(), size, |r, i| {
                if base[r] == 0.0 { 0.0 } else { slopes[(r, i)] / base[r] }
            });
            gram = gram.plus(1.0, &relative.transpose().product(&relative));
        }
        // The changes along the scores d have the size d'G d. With G = E E', the directions are the eigenvectors v of
        // E'C E, and the rank-one part of C that belongs to one of them is C E v (v'E'C E v)^{-1/2}.
        let (values, vectors) = symmetric_eigen(&gram)?;
        let largest = values.iter().copied().fold(0.0, f64::max);
        let seen: Vec<usize> = (0..size).filter(|&k| values[k] > 1e-12 * largest).collect();
        let root = Matrix::from_fn(size, seen.len(), |i, k| vectors[(i, seen[k])] * values[seen[k]].sqrt());
        let carried = c.product(&root);
        let (values, vectors) = symmetric_eigen(&root.transpose().product(&carried))?;
        let total: f64 = values.iter().map(|v| v.max(0.0)).sum();
        let (mut kept, mut list) = (0.0, Vec::new());
        for k in (0..seen.len()).rev() {
            if values[k] <= 0.0 || kept > enough * total {
                break;
            }
            kept += values[k];
            let direction: Vec<f64> = (0..seen.len()).map(|i| vectors[(i, k)] / values[k].sqrt()).collect();
            list.push(carried.times(&direction));
        }
        Ok(list)
    }
}

/// A rank-one part of the covariance of all scores, and the run whose states alone it moves.
struct Cause {
    name: String,
    run: Option<usize>,
    part: Vec<f64>,
}

fn remove(covariance: &mut Matrix, part: &[f64]) {
    for i in 0..part.len() {
        for j in 0..part.len() {
            covariance[(i, j)] -= part[i] * part[j];
        }
    }
}
