//! The most probable unknowns of a run of settled states, with Laplace's covariance.

use super::Run;
use super::prediction::Predicted;
use super::unknowns::unknowns;
use crate::assimilate::SensorKind;
use crate::{BaseState, ErrorComponent, FlowError, Pipe};
use rijke_inference::{
    Data, Forward, ForwardError, MapOptions, Observation, Parameter, Parameters, Posterior, Prediction, Prior,
};
use rijke_numerics::{Cholesky, Matrix, Order, symmetric_eigen};

/// A run with its posterior: Gaussian in normal scores.
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
    base_slopes: Matrix,
}

/// How well the readings are met.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Misfit {
    /// Twice the cost at the maximum without its constant: squares of residuals and of scores. Its expectation is the number
    /// of readings.
    pub chi_squared: f64,
    /// Number of readings.
    pub readings: usize,
    /// Whether the minimiser converged.
    pub converged: bool,
}

impl<'a> Settled<'a> {
    /// Fits `run`, which must have been [`Run::checked`].
    ///
    /// Cost: some ten linearisations of two steady states per unknown and state; 0.3 s for eight states.
    ///
    /// # Errors
    /// [`FlowError::Inference`] with the words of the minimiser, and those of [`Pipe::steady`].
    pub fn fit(pipe: &'a Pipe, run: &'a Run) -> Result<Self, FlowError> {
        let priors = unknowns(run, pipe);
        let size = priors.len();
        let mut settled = Self {
            pipe,
            run,
            priors,
            mean: vec![0.0; size],
            covariance: Matrix::identity(size),
            misfit: Misfit::default(),
            predicted: Vec::new(),
            base_slopes: Matrix::zeros(0, 0),
        };
        let words = |e: rijke_inference::InferenceError| FlowError::Inference(e.to_string());
        let score =
            |p: &Parameter| Parameter::new(&p.name, &p.symbol, "1", Prior::Normal { mean: 0.0, sd: 1.0 });
        let parameters = Parameters::new(settled.priors.iter().map(score).collect()).map_err(words)?;
        let readings: Vec<f64> = run.states.iter().flat_map(|s| s.readings.iter().copied()).collect();
        let covariance = run.covariance();
        let observation = Observation::new(format!("heater at {} m", run.heater), readings.clone())
            .with_floor(covariance.clone());
        let data = Data::new(vec![observation], Vec::new()).map_err(words)?;
        let posterior = Posterior::new(&settled, &data, &parameters).map_err(words)?;
        let fit = posterior.map(&MapOptions::default()).map_err(words)?;
        let laplace = posterior.laplace(&fit).map_err(words)?;
        let converged = fit.stop.converged();
        let (mean, posterior_covariance) = (fit.working, laplace.covariance);
        let predicted = settled.states(&mean, None)?;
        let (_, base_slopes) = settled.slopes(&mean, &predicted)?;
        let flat: Vec<f64> = predicted.iter().flat_map(|p| p.readings.iter().copied()).collect();
        let residual: Vec<f64> = readings.iter().zip(&flat).map(|(r, p)| r - p).collect();
        let white = Cholesky::new(&covariance)?.whiten(&residual);
        let squares = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>();
        settled.misfit =
            Misfit { chi_squared: squares(&white) + squares(&mean), readings: readings.len(), converged };
        settled.mean = mean;
        settled.covariance = posterior_covariance;
        settled.predicted = predicted;
        settled.base_slopes = base_slopes;
        Ok(settled)
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
                    states.iter().flat_map(|s| pick(s).to_vec()).collect()
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

    /// Base state of every state of the run, in its order. Errors are the principal directions of the posterior as seen
    /// by all states together, largest first; `cause` names them, so that the states share them. Directions that
    /// carry less than 1e-8 of the variance are left out.
    ///
    /// # Errors
    /// [`FlowError::Dense`] if the covariance is not positive definite.
    pub fn base_states(&self, cause: &str) -> Result<Vec<BaseState>, FlowError> {
        let size = self.mean.len();
        let moves = self.base_slopes.product(Cholesky::new(&self.covariance)?.lower());
        let values: Vec<f64> = self.predicted.iter().flat_map(|p| p.base.iter().copied()).collect();
        // Relative changes, so that fluxes and temperatures weigh alike; still gas has no scale.
        let weight = |k: usize| if values[k] == 0.0 { 0.0 } else { 1.0 / values[k] };
        let gram = Matrix::from_fn(size, size, |i, j| {
            (0..values.len()).map(|k| weight(k).powi(2) * moves[(k, i)] * moves[(k, j)]).sum()
        });
        let (eigenvalues, vectors) = symmetric_eigen(&gram)?;
        let largest = eigenvalues.iter().copied().fold(0.0, f64::max);
        let kept: Vec<usize> = (0..size).rev().filter(|&k| eigenvalues[k] > 1e-8 * largest).collect();
        let mut first = 0;
        let mut list = Vec::with_capacity(self.predicted.len());
        for state in &self.predicted {
            let along = |row: usize, k: usize| {
                (0..size).map(|i| moves[(first + row, i)] * vectors[(i, k)]).sum::<f64>()
            };
            let errors = kept.iter().enumerate().map(|(n, &k)| ErrorComponent {
                cause: format!("{cause}, {}", n + 1),
                mass_flux: along(0, k),
                heater_velocity: along(1, k),
                temperature: (2..state.base.len()).map(|row| along(row, k)).collect(),
            });
            let base = BaseState {
                gas: self.pipe.gas.clone(),
                pressure: self.pipe.air.pressure,
                mass_flux: state.base[0],
                heater_velocity: state.base[1],
                places: self.pipe.faces.clone(),
                temperature: state.base[2..].to_vec(),
                errors: errors.collect(),
            };
            first += state.base.len();
            list.push(base.checked()?);
        }
        Ok(list)
    }

    /// Posterior sd of the score of unknown `k`: 1 means that the data say nothing.
    #[must_use]
    pub fn shrinkage(&self, k: usize) -> f64 {
        self.covariance[(k, k)].max(0.0).sqrt()
    }
}

/// Step of the central differences, in scores.
const STEP: f64 = 1e-3;

impl Forward for Settled<'_> {
    fn predict(&self, scores: &[f64], order: Order) -> Result<Prediction, ForwardError> {
        let states = self.states(scores, None).map_err(ForwardError::recoverable)?;
        let values = states.iter().flat_map(|s| s.readings.iter().copied()).collect();
        let jacobian = match order {
            Order::Value => Matrix::zeros(0, 0),
            _ => self.slopes(scores, &states).map_err(ForwardError::recoverable)?.0,
        };
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
            let shared = m.zip(n).map_or(0.0, |(m, n)| self.common[(m, n)]);
            own + shared
        })
    }
}
