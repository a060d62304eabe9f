//! One run of settled states: its unknowns, its states and their slopes, and its part of the posterior.

use super::prediction::Predicted;
use super::run::SettledRun;
use super::unknowns::{moves_flow, unknowns};
use crate::error::FlowError;
use crate::infer::sensor::SensorKind;
use crate::tube::pipe::Pipe;
use rijke_inference::Parameter;
use rijke_numerics::Matrix;

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

    /// All states at `scores`, with the search for them started at those `near`.
    pub(crate) fn states(
        &self,
        scores: &[f64],
        near: Option<&[Predicted]>,
    ) -> Result<Vec<Predicted>, FlowError> {
        self.run.predict(self.pipe, &self.priors, scores, near)
    }

    /// Readings less `predicted` ones.
    pub(super) fn residual(&self, predicted: &[Predicted]) -> Vec<f64> {
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
        let around = self.run.around(self.pipe, &self.priors, scores, at)?;
        let mut moved = scores.to_vec();
        for i in 0..scores.len() {
            let kept = !moves_flow(i, self.run, self.pipe);
            let mut side = |h: f64| {
                moved[i] = scores[i] + h;
                let states = self.run.predict_near(self.pipe, &self.priors, &moved, &around, kept);
                moved[i] = scores[i];
                states
            };
            let (up, down) = (side(STEP)?, side(-STEP)?);
            for (which, into) in [&mut readings, &mut base].into_iter().enumerate() {
                let pairs = up.iter().zip(&down).flat_map(|(a, b)| a[which].iter().zip(&b[which]));
                pairs.enumerate().for_each(|(k, (a, b))| into[(k, i)] = (a - b) / (2.0 * STEP));
            }
        }
        Ok((readings, base))
    }

    /// Posterior sd of the score of unknown `k`: 1 means that the data say nothing.
    #[must_use]
    pub fn shrinkage(&self, k: usize) -> f64 {
        self.covariance[(k, k)].max(0.0).sqrt()
    }
}

/// Step of the central differences, in scores.
const STEP: f64 = 1e-3;
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
            own + match (arrival(place[a]), arrival(place[b])) {
                (Some(m), Some(n)) => self.common[(m, n)],
                (None, None) => self.offset_sd.powi(2),
                _ => 0.0,
            }
        })
    }
}
