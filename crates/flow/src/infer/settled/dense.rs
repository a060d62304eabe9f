//! The slow route to a joint fit: all scores of all runs in one dense posterior, searched by a trust region.

use super::fit::JointFit;
use super::of_run::Settled;
use super::run::SettledRun;
use super::tests::{SD, arrivals, empty, pipe, read};
use super::unknowns::{FIXED, shared_share};
use crate::tube::pipe::Pipe;
use rijke_inference::{
    Data, Forward, ForwardError, MapOptions, Observation, Parameter, Parameters, Posterior, Prediction,
    Prior, TrustRegion,
};
use rijke_numerics::{Matrix, Order, Streams};

/// Runs, and for each the matrix that makes its scores from all: the shared ones, then its own.
struct Dense<'a>(Vec<(Settled<'a>, Matrix)>);

impl Dense<'_> {
    fn new(runs: &[(Pipe, SettledRun)]) -> Dense<'_> {
        let models: Vec<Settled> = runs.iter().map(|(pipe, run)| Settled::at_prior(pipe, run)).collect();
        let size = FIXED + models.iter().map(|m| m.priors.len()).sum::<usize>();
        let mut first = FIXED;
        let turned = models.into_iter().map(|model| {
            let mut turn = Matrix::zeros(model.priors.len(), size);
            for k in 0..model.priors.len() {
                let share = if k < FIXED { shared_share(k) } else { 0.0 };
                if k < FIXED {
                    turn[(k, k)] = share;
                }
                turn[(k, first + k)] = (1.0 - share * share).sqrt();
            }
            first += model.priors.len();
            (model, turn)
        });
        Dense(turned.collect())
    }
}

impl Forward for Dense<'_> {
    fn predict(&self, scores: &[f64], _: Order) -> Result<Prediction, ForwardError> {
        let (mut values, mut jacobian) = (Vec::new(), Vec::new());
        for (model, turn) in &self.0 {
            let own = turn.times(scores);
            let states = model.states(&own, None).map_err(ForwardError::recoverable)?;
            values.extend(states.iter().flat_map(|s| s.readings.iter().copied()));
            let slopes = model.slopes(&own, &states).map_err(ForwardError::recoverable)?.0;
            jacobian.extend_from_slice(slopes.product(turn).as_slice());
        }
        let size = scores.len();
        let jacobian = Matrix::from_fn(values.len(), size, |i, j| jacobian[i * size + j]);
        Ok(Prediction { values, jacobian, curvature: Vec::new() })
    }

    fn highest_order(&self) -> Order {
        Order::First
    }
}

#[test]
fn oracle_joint_fit_by_one_dense_posterior() {
    let mut stream = Streams::new(5).stream("dense");
    let runs: Vec<(Pipe, SettledRun)> = [0.25, 0.5, 0.7]
        .map(|heater| {
            let (pipe, mut run) = (pipe(heater), empty(heater, &arrivals(), SD));
            read(&pipe, &mut run, SD, &mut stream);
            (pipe, run)
        })
        .into();
    let dense = Dense::new(&runs);
    let size = dense.0[0].1.columns();
    let score = |k: usize| {
        let name = format!("score {k}");
        Parameter::new(&name, &name, "1", Prior::Normal { mean: 0.0, sd: 1.0 })
    };
    let parameters = Parameters::new((0..size).map(score).collect()).unwrap();
    let observation = |(_, run): &(Pipe, SettledRun)| {
        let readings = run.states.iter().flat_map(|s| s.readings.iter().copied()).collect();
        Observation::new(format!("heater at {} m", run.heater), readings).with_floor(run.covariance())
    };
    let data = Data::new(runs.iter().map(observation).collect(), Vec::new()).unwrap();
    let posterior = Posterior::new(&dense, &data, &parameters).unwrap();
    let search = TrustRegion { tolerance: 1e-8, ..TrustRegion::default() };
    let best = posterior.map(&MapOptions { search, start: None }).unwrap();
    let covariance = posterior.laplace(&best).unwrap().covariance;
    let fit = JointFit::new(&runs).unwrap();
    for (run, (_, turn)) in fit.runs.iter().zip(&dense.0) {
        assert!(run.misfit.converged);
        let (mean, own) = (turn.times(&best.working), turn.product(&covariance).product(&turn.transpose()));
        for i in 0..mean.len() {
            let sd = own[(i, i)].sqrt();
            assert!((run.mean[i] - mean[i]).abs() < 5e-3 * sd, "{i}: {} {} +- {sd}", run.mean[i], mean[i]);
            for j in 0..=i {
                let scale = sd * own[(j, j)].sqrt();
                let off = run.covariance[(i, j)] - own[(i, j)];
                assert!(off.abs() < 5e-3 * scale, "{i}, {j}: {off} of {scale}");
            }
        }
    }
    // What two runs have in common: the velocities at 180 W, by the causes that they share.
    let states = fit.base_states().unwrap();
    let (a, b) = (&states[3].1, &states[11].1);
    let shared = a.errors.iter().flat_map(|e| {
        b.errors.iter().filter(|o| o.cause == e.cause).map(|o| e.heater_velocity * o.heater_velocity)
    });
    let row = |p: usize| {
        let run = &fit.runs[p];
        let first: usize = run.predicted[..3].iter().map(|s| s.base.len()).sum();
        dense.0[p].1.transpose().times(run.base_slopes.row(first + 1))
    };
    let exact = covariance.times(&row(2)).iter().zip(row(0)).map(|(a, b)| a * b).sum::<f64>();
    let found = shared.sum::<f64>();
    assert!((found / exact - 1.0).abs() < 0.02, "{found} {exact}");
}
