//! The most probable unknowns of all runs together, with Laplace's covariance.

use super::prediction::Predicted;
use super::run::Run;
use super::unknowns::{FIXED, shared_share, unknowns};
use crate::error::FlowError;
use crate::infer::sensor::SensorKind;
use crate::tube::pipe::Pipe;
use rayon::prelude::*;
use rijke_inference::{
    Data, Forward, ForwardError, MapOptions, Observation, Parameter, Parameters, Posterior, Prediction,
    Prior, TrustRegion,
};
use rijke_numerics::{Cholesky, Matrix, Order};

/// Runs with their joint posterior.
///
/// What is unknown belongs to one rig: the power meter is the same at every place of the heater, a correlation that is
/// 20 % too high is so everywhere. But a model that is wrong is not wrong by the same amount everywhere. The normal score of
/// unknown k in run p is therefore a_k s_k + sqrt(1 - a_k^2) o_pk, with s_k shared by all runs and o_pk its own, both standard
/// normal a priori: the prior of each run by itself is unchanged. With one run this is a fit of that run alone.
#[derive(Clone, Debug)]
pub struct Fit<'a> {
    /// The runs, each with its own part of the posterior.
    pub runs: Vec<Settled<'a>>,
    /// Covariance of all scores: shared ones, then those of each run in turn.
    pub(crate) covariance: Matrix,
    /// Per run, its scores from all scores.
    pub(crate) turns: Vec<Matrix>,
}

/// A run with its own part of the posterior: Gaussian in normal scores.
#[derive(Clone, Debug)]
pub struct Settled<'a> {
    pub(crate) pipe: &'a Pipe,
    pub(crate) run: &'a Run,
    /// The unknowns and their priors.
    pub priors: Vec<Parameter>,
    /// Mean of the normal scores.
    pub mean: Vec<f64>,
    /// Their covariance.
    pub covariance: Matrix,
    /// How well the readings are met.
    pub misfit: Misfit,
    pub(crate) predicted: Vec<Predicted>,
    /// Derivatives of the base vectors in the scores, one state after the other.
    pub(crate) base_slopes: Matrix,
}

/// How well the readings of a run are met.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Misfit {
    /// Twice the cost at the maximum without its constant: squares of residuals over their sd, and of the run's scores. Its
    /// expectation is the number of readings.
    pub chi_squared: f64,
    /// Number of readings.
    pub readings: usize,
    /// Whether the minimiser converged.
    pub converged: bool,
}

impl<'a> Fit<'a> {
    /// Fits `runs`, which must have been [`Run::checked`], together.
    ///
    /// Cost: some eight linearisations, each of two steady states per unknown and state: 0.2 s of CPU per run of eight
    /// states, and the algebra of 27 unknowns per run.
    ///
    /// # Errors
    /// [`FlowError::Inference`] with the words of the minimiser, and those of [`Pipe::steady`].
    pub fn new(runs: &'a [(Pipe, Run)]) -> Result<Self, FlowError> {
        let models: Vec<Settled> = runs.iter().map(|(pipe, run)| Settled::at_prior(pipe, run)).collect();
        let (turns, size) = turns(&models);
        let mut fit = Self { runs: models, covariance: Matrix::identity(size), turns };
        let words = |e: rijke_inference::InferenceError| FlowError::Inference(e.to_string());
        let score = |k: usize| {
            let name = format!("score {k}");
            Parameter::new(&name, &name, "1", Prior::Normal { mean: 0.0, sd: 1.0 })
        };
        let parameters = Parameters::new((0..size).map(score).collect()).map_err(words)?;
        let observations = runs.iter().map(|(_, run)| {
            let readings = run.states.iter().flat_map(|s| s.readings.iter().copied()).collect();
            Observation::new(format!("heater at {} m", run.heater), readings).with_floor(run.covariance())
        });
        let data = Data::new(observations.collect(), Vec::new()).map_err(words)?;
        let posterior = Posterior::new(&fit, &data, &parameters).map_err(words)?;
        let search = TrustRegion { tolerance: CLOSE, ..TrustRegion::default() };
        let best = posterior.map(&MapOptions { search, start: None }).map_err(words)?;
        let laplace = posterior.laplace(&best).map_err(words)?;
        let converged = best.stop.converged();
        fit.covariance = laplace.covariance;
        let (covariance, turns) = (&fit.covariance, &fit.turns);
        fit.runs
            .par_iter_mut()
            .zip(turns)
            .map(|(run, turn)| run.conclude(turn, &best.working, covariance, converged))
            .collect::<Result<(), FlowError>>()?;
        Ok(fit)
    }
}

/// Per run, the matrix that makes its scores from all scores; and the number of all scores.
fn turns(runs: &[Settled<'_>]) -> (Vec<Matrix>, usize) {
    let own = |k: usize| k >= FIXED || shared_share(k) < 1.0;
    let size = FIXED + runs.iter().map(|r| (0..r.priors.len()).filter(|&k| own(k)).count()).sum::<usize>();
    let mut next = FIXED;
    let turns = runs
        .iter()
        .map(|run| {
            let mut turn = Matrix::zeros(run.priors.len(), size);
            for k in 0..run.priors.len() {
                let share = if k < FIXED { shared_share(k) } else { 0.0 };
                if k < FIXED {
                    turn[(k, k)] = share;
                }
                if own(k) {
                    turn[(k, next)] = (1.0 - share * share).sqrt();
                    next += 1;
                }
            }
            turn
        })
        .collect();
    (turns, size)
}

impl<'a> Settled<'a> {
    pub(crate) fn at_prior(pipe: &'a Pipe, run: &'a Run) -> Self {
        let priors = unknowns(run, pipe);
        let size = priors.len();
        Self {
            pipe,
            run,
            priors,
            mean: vec![0.0; size],
            covariance: Matrix::identity(size),
            misfit: Misfit::default(),
            predicted: Vec::new(),
            base_slopes: Matrix::zeros(0, 0),
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

    /// Takes its part of the joint posterior.
    fn conclude(
        &mut self,
        turn: &Matrix,
        scores: &[f64],
        covariance: &Matrix,
        converged: bool,
    ) -> Result<(), FlowError> {
        self.mean = turn.times(scores);
        self.covariance = turn.product(covariance).product(&turn.transpose());
        self.predicted = self.states(&self.mean, None)?;
        self.base_slopes = self.slopes(&self.mean, &self.predicted)?.1;
        let pairs = self.run.states.iter().zip(&self.predicted);
        let residual: Vec<f64> =
            pairs.flat_map(|(s, p)| s.readings.iter().zip(&p.readings).map(|(r, p)| r - p)).collect();
        let white = Cholesky::new(&self.run.covariance())?.whiten(&residual);
        let squares = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>();
        self.misfit = Misfit {
            chi_squared: squares(&white) + squares(&self.mean),
            readings: residual.len(),
            converged,
        };
        Ok(())
    }

    /// Derivatives of readings and of base vectors in the scores, by central differences: the closures move the grid and
    /// everything else, so this is the one route that serves all unknowns. Error below 1e-6 of a derivative.
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

/// Drop in J that may be left, nats: a thousandth of an sd, which differences still resolve.
const CLOSE: f64 = 1e-6;
/// Step of the central differences, in scores.
const STEP: f64 = 1e-3;

impl Forward for Fit<'_> {
    fn predict(&self, scores: &[f64], order: Order) -> Result<Prediction, ForwardError> {
        let one = |(run, turn): (&Settled<'_>, &Matrix)| {
            let own = turn.times(scores);
            let states = run.states(&own, None)?;
            let jacobian = match order {
                Order::Value => None,
                _ => Some(run.slopes(&own, &states)?.0.product(turn)),
            };
            Ok((states, jacobian))
        };
        let parts: Result<Vec<_>, FlowError> = self.runs.par_iter().zip(&self.turns).map(one).collect();
        let parts = parts.map_err(ForwardError::recoverable)?;
        let readings =
            parts.iter().flat_map(|(states, _)| states.iter().flat_map(|s| s.readings.iter().copied()));
        let values: Vec<f64> = readings.collect();
        let mut jacobian = Matrix::zeros(if order == Order::Value { 0 } else { values.len() }, scores.len());
        let slopes = parts.iter().filter_map(|(_, j)| j.as_ref()).flat_map(|j| j.as_slice());
        jacobian.as_mut_slice().iter_mut().zip(slopes).for_each(|(entry, slope)| *entry = *slope);
        Ok(Prediction { values, jacobian, curvature: Vec::new() })
    }

    fn highest_order(&self) -> Order {
        Order::First
    }
}

impl Run {
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
