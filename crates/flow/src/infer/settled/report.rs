//! A fitted run as numbers for figures, and its base states by name.

use super::fit::JointFit;
use super::of_run::Settled;
use super::run::SIX;
use super::unknowns::FIXED;
use crate::base::state::BaseState;
use crate::error::FlowError;
use crate::infer::health::FlowHealth;
use crate::infer::report::{NamedStates, PowerReport, ResidualReport, RunReport, UnknownReport};

impl JointFit<'_> {
    /// One report per run that was read, and the base state of every operating point.
    ///
    /// # Errors
    /// Those of [`JointFit::base_states`].
    pub fn report(&self) -> Result<(Vec<RunReport>, NamedStates), FlowError> {
        let states = self.base_states()?;
        let mut rest = states.as_slice();
        let mut reports = Vec::with_capacity(self.runs.len());
        for run in &self.runs {
            let (mine, others) = rest.split_at(run.run.states.len());
            rest = others;
            if run.run.is_read() {
                reports.push(run.report(mine)?);
            }
        }
        Ok((reports, states))
    }
}

impl Settled<'_> {
    /// Parameters and closures further than 2.5 prior sd from the centre.
    fn at_bound(&self) -> Vec<String> {
        (0..FIXED).filter(|&k| self.mean[k].abs() > 2.5).map(|k| self.priors[k].name.clone()).collect()
    }

    /// The run as numbers, states in the order of power.
    fn report(&self, bases: &[(String, BaseState)]) -> Result<RunReport, FlowError> {
        let covariance = self.run.covariance();
        let mut first = 0;
        let mut powers = Vec::new();
        for ((state, predicted), (_, base)) in self.run.states.iter().zip(&self.predicted).zip(bases) {
            let residual = |j: usize| ResidualReport {
                sensor: state.sensors[j],
                reading: state.readings[j],
                fitted: predicted.readings[j],
                sd: covariance[(first + j, first + j)].sqrt(),
            };
            let residuals = (0..state.readings.len()).map(residual).collect();
            first += state.readings.len();
            powers.push(PowerReport::new(
                state.id.clone(),
                state.power,
                base.temperature[0],
                base,
                residuals,
            ));
        }
        powers.sort_by(|a, b| a.power_w.total_cmp(&b.power_w));
        let named_where = |test: &dyn Fn(usize) -> bool| {
            (0..SIX).filter(|&k| test(k)).map(|k| self.priors[k].name.clone()).collect()
        };
        let readings = self.misfit.readings as f64;
        let health = FlowHealth {
            chi_squared: self.misfit.chi_squared / readings,
            chi_squared_sd: (2.0 / readings).sqrt(),
            whiteness: Vec::new(),
            bins: self.run.states.len(),
            unidentified: named_where(&|k| self.shrinkage(k) > 0.7),
            at_bound: self.at_bound(),
            tensions: Vec::new(),
            converged: self.misfit.converged,
        };
        let unknown = |(k, p)| UnknownReport::new(p, self.mean[k], self.shrinkage(k));
        Ok(RunReport {
            heater_m: self.run.heater,
            method: None,
            warnings: health.warnings(),
            health: Some(health),
            unknowns: self.priors.iter().enumerate().map(unknown).collect::<Result<_, _>>()?,
            powers,
            settling: self.settling()?,
            history: Vec::new(),
            innovation_chi_squared: None,
            failed_members: 0,
            effective_rank: None,
        })
    }
}
