//! The most probable unknowns of all runs together, with Laplace's covariance.

use super::joint::{Arrow, Scores};
use super::prediction::Predicted;
use super::readings::Readings;
use super::run::SettledRun;
use super::unknowns::unknowns;
use crate::error::FlowError;
use crate::infer::sensor::SensorKind;
use crate::tube::pipe::Pipe;
use rayon::prelude::*;
use rijke_inference::Parameter;
use rijke_numerics::{Cholesky, Matrix, dot};

/// Runs with their joint posterior.
///
/// What is unknown belongs to one rig: the power meter is the same at every place of the heater, a
/// correlation that is 20 % too high is so everywhere. But a model that is wrong is not wrong by the same
/// amount everywhere. The normal score of unknown k in run p is therefore a_k s_k + sqrt(1 - a_k^2) o_pk,
/// with s_k shared by all runs and o_pk its own, both standard normal a priori: the prior of each run by
/// itself is unchanged. With one run this is a fit of that run alone.
#[derive(Clone, Debug)]
pub struct JointFit<'a> {
    /// The runs, each with its own part of the posterior.
    pub runs: Vec<Settled<'a>>,
}

/// A run with its own part of the posterior: Gaussian in normal scores.
#[derive(Clone, Debug)]
pub struct Settled<'a> {
    pub(crate) pipe: &'a Pipe,
    pub(crate) run: &'a SettledRun,
    /// The unknowns and their priors.
    pub priors: Vec<Parameter>,
    /// Mean of the normal scores.
    pub mean: Vec<f64>,
    /// Their covariance.
    pub covariance: Matrix,
    /// How well the readings are met.
    pub misfit: ReadingMisfit,
    pub(crate) predicted: Vec<Predicted>,
    /// Derivatives of the base vectors in the scores, one state after the other.
    pub(crate) base_slopes: Matrix,
    /// What the readings say of the normal scores: the inverse of a covariance.
    pub(crate) information: Matrix,
}

/// A run and its slopes at some scores.
struct Linear {
    states: Vec<Predicted>,
    base_slopes: Matrix,
    information: Matrix,
    /// Slope of half the squares of residuals, down.
    down: Vec<f64>,
    /// Of each reading how far it is from the model, in standard deviations of noise and priors, and how far
    /// it would be after one step; the larger.
    off: Vec<f64>,
}

/// How well the readings of a run are met.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadingMisfit {
    /// Twice the cost at the maximum without its constant: squares of residuals over their sd, and of the
    /// run's scores. Its expectation is the number of readings.
    pub chi_squared: f64,
    /// Number of readings.
    pub readings: usize,
    /// Whether the minimiser converged.
    pub converged: bool,
}

impl<'a> JointFit<'a> {
    /// Fits `runs`, which must have been [`SettledRun::checked`], together: Gauss and Newton's method, damped
    /// after Levenberg and Marquardt.
    ///
    /// Cost: some eight linearisations, each of two steady states per unknown and state: 0.2 s of CPU per run
    /// of eight states, and the algebra of 27 unknowns per run; at most thirty linearisations.
    ///
    /// # Errors
    /// [`FlowError::FarOff`] for readings that no flow near the priors has, and those of [`Pipe::steady`].
    pub fn new(runs: &'a [(Pipe, SettledRun)]) -> Result<Self, FlowError> {
        let mut fit = Self { runs: runs.iter().map(|(pipe, run)| Settled::at_prior(pipe, run)).collect() };
        let noise =
            runs.iter().map(|(_, run)| Cholesky::new(&run.covariance())).collect::<Result<Vec<_>, _>>()?;
        let mut scores = Scores::centre(fit.runs.iter().map(|run| run.priors.len()));
        let mut states = fit.states(&scores)?;
        let mut cost = fit.cost(&scores, &states, &noise);
        let (mut damping, mut steps) = (0.0, 0);
        let (at, converged) = loop {
            let at = fit.linear(&scores, std::mem::take(&mut states), &noise)?;
            if steps == 0 {
                fit.near_the_prior(&at)?;
            }
            let down = scores.descent(at.iter().map(|run| run.down.as_slice()));
            let information = || at.iter().map(|run| &run.information);
            let full = Arrow::new(information(), 0.0)?.step(&down);
            let left = 0.5 * down.dot(&full) / runs.len() as f64;
            if left < CLOSE || steps == STEPS {
                break (at, left < CLOSE);
            }
            let mut better = None;
            while better.is_none() && damping < HELD {
                let step = Arrow::new(information(), damping)?.step(&down);
                let trial = scores.plus(1.0, &step);
                let found = fit.states(&trial).map(|states| (fit.cost(&trial, &states, &noise), states));
                // Where no flow exists, as where the cost rises, a shorter step.
                match found {
                    Ok((lower, states)) if lower < cost => better = Some((trial, lower, states)),
                    // The model is piecewise smooth: so near, its kinks alone are left.
                    _ if left < KINKS => break,
                    _ => damping = (10.0 * damping).max(1.0),
                }
            }
            let Some((trial, lower, found)) = better else { break (at, left < KINKS) };
            (scores, cost, states) = (trial, lower, found);
            damping = if damping > 1.0 { 0.1 * damping } else { 0.0 };
            steps += 1;
        };
        let joint = Arrow::new(at.iter().map(|run| &run.information), 0.0)?;
        for (p, (run, at)) in fit.runs.iter_mut().zip(at).enumerate() {
            let (along, own) = joint.of(p);
            run.mean = scores.of(p);
            run.covariance = own.plus(1.0, &along.product(&joint.shared).product(&along.transpose()));
            let white = noise[p].whiten(&run.residual(&at.states));
            run.misfit.chi_squared = dot(&white, &white) + dot(&run.mean, &run.mean);
            run.misfit.readings = white.len();
            run.misfit.converged = converged;
            (run.predicted, run.base_slopes, run.information) = (at.states, at.base_slopes, at.information);
        }
        Ok(fit)
    }

    fn states(&self, scores: &Scores) -> Result<Vec<Vec<Predicted>>, FlowError> {
        self.runs.par_iter().enumerate().map(|(p, run)| run.states(&scores.of(p), None)).collect()
    }

    fn cost(&self, scores: &Scores, states: &[Vec<Predicted>], noise: &[Cholesky]) -> f64 {
        let squares = |((run, states), noise): ((&Settled<'_>, &Vec<Predicted>), &Cholesky)| {
            let white = noise.whiten(&run.residual(states));
            dot(&white, &white)
        };
        let misfit: f64 = self.runs.iter().zip(states).zip(noise).map(squares).sum();
        0.5 * (misfit + scores.dot(scores))
    }

    fn linear(
        &self,
        scores: &Scores,
        states: Vec<Vec<Predicted>>,
        noise: &[Cholesky],
    ) -> Result<Vec<Linear>, FlowError> {
        let one = |(p, states): (usize, Vec<Predicted>)| {
            let run = &self.runs[p];
            let (readings, base_slopes) = run.slopes(&scores.of(p), &states)?;
            let columns = readings.transpose();
            let white: Vec<Vec<f64>> = (0..columns.rows()).map(|k| noise[p].whiten(columns.row(k))).collect();
            let residual = run.residual(&states);
            let white_residual = noise[p].whiten(&residual);
            let information = Matrix::from_fn(white.len(), white.len(), |i, j| dot(&white[i], &white[j]));
            let down: Vec<f64> = white.iter().map(|w| dot(w, &white_residual)).collect();
            let step = Cholesky::new(&Matrix::identity(down.len()).plus(1.0, &information))?.solve(&down);
            let off = residual.iter().enumerate().map(|(j, r)| {
                let [noise, slopes] = [noise[p].lower().row(j), readings.row(j)];
                let left = white_residual[j] - white.iter().zip(&step).map(|(w, s)| w[j] * s).sum::<f64>();
                left.abs().max(r.abs() / (dot(noise, noise) + dot(slopes, slopes)).sqrt())
            });
            let off = off.collect();
            Ok(Linear { states, base_slopes, information, down, off })
        };
        states.into_par_iter().enumerate().map(one).collect()
    }

    /// Refuses a run most of whose readings lie farther from the model than unknowns near their priors can
    /// move it, before the search tries. A few that are wrong are left to the fit and its warnings.
    fn near_the_prior(&self, at: &[Linear]) -> Result<(), FlowError> {
        for (run, at) in self.runs.iter().zip(at) {
            let far = at.off.iter().filter(|z| **z > FAR).count();
            if 2 * far <= at.off.len() {
                continue;
            }
            let readings = run.run.states.iter().zip(&at.states).flat_map(|(state, predicted)| {
                let each = state.sensors.iter().zip(&state.readings).zip(&predicted.readings);
                each.map(|((sensor, reading), model)| (&state.id, *sensor, *reading, *model))
            });
            let far = |r: f64, m: f64| (r / m).ln().abs();
            let worst = readings.max_by(|a, b| far(a.2, a.3).total_cmp(&far(b.2, b.3)));
            if let Some((id, sensor, reading, model)) = worst {
                let file = match sensor {
                    SensorKind::Arrival { .. } => "clicks.csv",
                    _ => Readings::FILE,
                };
                return Err(FlowError::FarOff {
                    id: id.clone(),
                    file,
                    sensor: sensor.to_string(),
                    reading,
                    model,
                });
            }
        }
        Ok(())
    }
}

impl<'a> Settled<'a> {
    pub(crate) fn at_prior(pipe: &'a Pipe, run: &'a SettledRun) -> Self {
        let priors = unknowns(run, pipe);
        let size = priors.len();
        Self {
            pipe,
            run,
            priors,
            mean: vec![0.0; size],
            covariance: Matrix::identity(size),
            misfit: ReadingMisfit::default(),
            predicted: Vec::new(),
            base_slopes: Matrix::zeros(0, 0),
            information: Matrix::zeros(0, 0),
        }
    }

    /// All states at `scores`; `near` are steady states to start from.
    pub(crate) fn states(
        &self,
        scores: &[f64],
        near: Option<&[Predicted]>,
    ) -> Result<Vec<Predicted>, FlowError> {
        self.run.predict(self.pipe, &self.priors, scores, near)
    }

    /// Readings less `predicted` ones.
    fn residual(&self, predicted: &[Predicted]) -> Vec<f64> {
        let pairs = self.run.states.iter().zip(predicted);
        pairs.flat_map(|(s, p)| s.readings.iter().zip(&p.readings).map(|(r, p)| r - p)).collect()
    }

    /// Derivatives of readings and of base vectors in the scores, by central differences: the closures move
    /// the grid and everything else, so this is the one route that serves all unknowns. Error below 1e-6 of a
    /// derivative.
    pub(crate) fn slopes(&self, scores: &[f64], at: &[Predicted]) -> Result<(Matrix, Matrix), FlowError> {
        let count = |f: fn(&Predicted) -> usize| at.iter().map(f).sum::<usize>();
        let mut readings = Matrix::zeros(count(|p| p.readings.len()), scores.len());
        let mut base = Matrix::zeros(count(|p| p.base.len()), scores.len());
        let mut moved = scores.to_vec();
        for i in 0..scores.len() {
            let mut side = |h: f64| {
                moved[i] = scores[i] + h;
                let states = self.states(&moved, Some(at));
                moved[i] = scores[i];
                states
            };
            let (up, down) = (side(STEP)?, side(-STEP)?);
            let difference = |pick: fn(&Predicted) -> &[f64], into: &mut Matrix| {
                let values = |states: &[Predicted]| -> Vec<f64> {
                    states.iter().flat_map(|s| pick(s).iter().copied()).collect()
                };
                for (k, (a, b)) in values(&up).iter().zip(values(&down)).enumerate() {
                    into[(k, i)] = (a - b) / (2.0 * STEP);
                }
            };
            difference(|p| &p.readings, &mut readings);
            difference(|p| &p.base, &mut base);
        }
        Ok((readings, base))
    }

    /// Posterior sd of the score of unknown `k`: 1 means that the data say nothing.
    #[must_use]
    pub fn shrinkage(&self, k: usize) -> f64 {
        self.covariance[(k, k)].max(0.0).sqrt()
    }
}

/// Drop in J that may be left of each run, nats: a two-hundredth of an sd, which differences still resolve.
const CLOSE: f64 = 1e-5;
/// The same where no full step is better: a seventieth of an sd.
const KINKS: f64 = 1e-4;
/// Step of the central differences, in scores.
const STEP: f64 = 1e-3;
/// Most linearisations; five to twelve are usual.
const STEPS: usize = 30;
/// Damping, in precisions of the prior, at which a search that finds nothing better ends.
const HELD: f64 = 1e10;
/// Standard deviations by which half of the readings may miss the model.
const FAR: f64 = 5.0;

impl SettledRun {
    /// Covariance of all readings, one state after the other.
    pub(crate) fn covariance(&self) -> Matrix {
        let place: Vec<(usize, usize)> = self
            .states
            .iter()
            .enumerate()
            .flat_map(|(s, state)| (0..state.readings.len()).map(move |j| (s, j)))
            .collect();
        let arrival = |(s, j): (usize, usize)| match self.states[s].sensors[j] {
            SensorKind::Arrival { microphone } => Some(microphone),
            _ => None,
        };
        Matrix::from_fn(place.len(), place.len(), |a, b| {
            let ((s, i), (t, j)) = (place[a], place[b]);
            let own = if s == t { self.states[s].noise[(i, j)] } else { 0.0 };
            let (m, n) = (arrival(place[a]), arrival(place[b]));
            own + m.zip(n).map_or(0.0, |(m, n)| self.common[(m, n)])
        })
    }
}
