//! The most probable unknowns of all runs together, with Laplace's covariance.

use super::joint::Arrow;
use super::of_run::Settled;
use super::run::SettledRun;
use super::search::{Found, search};
use crate::error::FlowError;
use crate::tube::pipe::Pipe;
use rijke_numerics::{Cholesky, dot};

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
    /// How often the search took slopes: nearly all of the work.
    pub linearisations: usize,
}

impl<'a> JointFit<'a> {
    /// Fits `runs`, which must have been [`SettledRun::checked`], together.
    ///
    /// Cost: three to six linearisations, each of two steady states per unknown that moves the flow and per
    /// state: 0.1 s of CPU per run of eight states, and the algebra of 27 unknowns per run; at most thirty
    /// linearisations.
    ///
    /// # Errors
    /// [`FlowError::FarOff`] for readings that no flow near the priors has, and those of [`Pipe::steady`].
    pub fn new(runs: &'a [(Pipe, SettledRun)]) -> Result<Self, FlowError> {
        let at_prior = runs.iter().map(|(pipe, run)| Settled::at_prior(pipe, run)).collect();
        let mut fit = Self { runs: at_prior, linearisations: 0 };
        let noise =
            runs.iter().map(|(_, run)| Cholesky::new(&run.covariance())).collect::<Result<Vec<_>, _>>()?;
        let Found { at, slopes, converged, linearisations } = search(&fit.runs, &noise)?;
        fit.linearisations = linearisations;
        let joint = Arrow::new(slopes.iter().map(|run| &run.information), 0.0)?;
        let parts = at.states.into_iter().zip(at.white).zip(slopes);
        for (p, (run, ((states, white), slopes))) in fit.runs.iter_mut().zip(parts).enumerate() {
            let (along, own) = joint.of(p);
            run.mean = at.scores.of(p);
            run.covariance = own.plus(1.0, &along.product(&joint.shared).product(&along.transpose()));
            run.misfit.chi_squared = dot(&white, &white) + dot(&run.mean, &run.mean);
            run.misfit.readings = white.len();
            run.misfit.converged = converged;
            (run.predicted, run.base_slopes, run.information) = (states, slopes.base, slopes.information);
        }
        Ok(fit)
    }
}
