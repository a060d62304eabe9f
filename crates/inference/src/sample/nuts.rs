//! A gradient sampler as sampler: NUTS for draws of the posterior, bridge sampling for the evidence.

use super::bridge::bridge;
use super::sampler::{Integrated, Sampler, Target};
use crate::density::Calls;
use crate::error::InferenceError;
use nuts_rs::{Chain, CpuLogpFunc, CpuMath, CpuMathError, DiagNutsSettings, HasDims, LogpError, Settings};
use rand::RngExt;
use rand_distr::StandardNormal;
use rijke_numerics::Streams;
use std::cell::{Cell, RefCell};
use std::collections::HashMap;

/// The No-U-Turn sampler (Hoffman & Gelman 2014, JMLR 15, 1593) in the crate `nuts-rs`, started from a draw
/// of the prior; the evidence follows from its draws by bridge sampling. Draws are doubled until the error is
/// small enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nuts {
    /// Draws spent on step size and mass matrix, which are then thrown away.
    pub tune: usize,
    /// Draws before the evidence is computed for the first time.
    pub draws: usize,
    /// Draws after which to give up.
    pub max_draws: usize,
    /// Stated error of ln of the evidence, nats, at which to end.
    pub error: f64,
    /// Random streams.
    pub streams: Streams,
}

impl Nuts {
    /// Settings for a statistical error of `error` nats.
    #[must_use]
    pub fn with_error(error: f64, streams: Streams) -> Self {
        Self { tune: 400, draws: 250, max_draws: 64_000, error, streams }
    }
}

/// Draws from the prior at which to look for a start.
const STARTS: usize = 100;

impl Sampler for Nuts {
    fn name(&self) -> &'static str {
        "NUTS and bridge sampling"
    }

    fn integrate(&self, target: &dyn Target) -> Result<Integrated, InferenceError> {
        let mut stream = self.streams.stream("inference/nuts");
        let (calls, fatal) = (Cell::new(Calls::default()), RefCell::new(None));
        let stopped = |error: &dyn std::fmt::Display| match fatal.borrow_mut().take() {
            Some(error) => error,
            None => InferenceError::Sampler { sampler: "the gradient sampler", problem: error.to_string() },
        };
        let settings = DiagNutsSettings { num_tune: self.tune as u64, ..DiagNutsSettings::default() };
        let density = Density { target, calls: &calls, fatal: &fatal };
        let mut chain = settings.new_chain(0, CpuMath::new(density), &mut stream).map_err(|e| stopped(&e))?;
        let mut start = Err(stopped(&"no draw of the prior has a likelihood with a gradient"));
        for _ in 0..STARTS {
            let xi: Vec<f64> = (0..target.size()).map(|_| stream.sample(StandardNormal)).collect();
            start = chain.set_position(&xi).map_err(|e| stopped(&e));
            if start.is_ok() {
                break;
            }
        }
        start?;
        for _ in 0..self.tune {
            chain.draw().map_err(|e| stopped(&e))?;
        }
        let mut draws: Vec<Vec<f64>> = Vec::new();
        let mut want = self.draws.max(4 * (target.size() + 1));
        loop {
            while draws.len() < want {
                draws.push(chain.draw().map_err(|e| stopped(&e))?.0.into_vec());
            }
            let mut spent = calls.get();
            let found = bridge(target, &draws, &mut stream, &mut spent)?;
            calls.set(spent);
            let finished = found.standard_error <= self.error;
            if finished || want >= self.max_draws {
                return Ok(Integrated {
                    ln_marginal: found.ln_marginal,
                    standard_error: found.standard_error,
                    information: found.information,
                    draws: draws.iter().map(|xi| target.working(xi)).collect(),
                    finished,
                    calls: calls.get(),
                });
            }
            want *= 2;
        }
    }
}

/// The target as the sampler wants it: likelihood times a standard normal prior.
struct Density<'a> {
    target: &'a dyn Target,
    calls: &'a Cell<Calls>,
    /// An error that no other point would mend.
    fatal: &'a RefCell<Option<InferenceError>>,
}

/// What the sampler is told of a failure.
#[derive(Debug, thiserror::Error)]
#[error("{words}")]
struct Failure {
    words: String,
    recoverable: bool,
}

impl LogpError for Failure {
    fn is_recoverable(&self) -> bool {
        self.recoverable
    }
}

impl HasDims for Density<'_> {
    fn dim_sizes(&self) -> HashMap<String, u64> {
        HashMap::from([("unconstrained_parameter".to_owned(), self.target.size() as u64)])
    }
}

impl CpuLogpFunc for Density<'_> {
    type LogpError = Failure;
    type FlowParameters = ();
    type ExpandedVector = Vec<f64>;

    fn dim(&self) -> usize {
        self.target.size()
    }

    fn logp(&mut self, xi: &[f64], gradient: &mut [f64]) -> Result<f64, Failure> {
        let mut calls = self.calls.get();
        calls.first += 1;
        let found = self.target.gradient(xi);
        calls.failed += usize::from(found.is_err());
        self.calls.set(calls);
        match found {
            Ok((value, slopes)) => {
                for ((to, slope), x) in gradient.iter_mut().zip(slopes).zip(xi) {
                    *to = slope - x;
                }
                Ok(value - 0.5 * xi.iter().map(|x| x * x).sum::<f64>())
            }
            Err(error) => {
                let failure = Failure { words: error.to_string(), recoverable: error.is_recoverable() };
                if !failure.recoverable {
                    self.fatal.replace(Some(error));
                }
                Err(failure)
            }
        }
    }

    fn expand_vector<R: nuts_rs::rand::Rng + ?Sized>(
        &mut self,
        _rng: &mut R,
        xi: &[f64],
    ) -> Result<Vec<f64>, CpuMathError> {
        Ok(xi.to_vec())
    }
}
