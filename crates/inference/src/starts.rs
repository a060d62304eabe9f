//! The search from several starts.

use crate::health::{MODE_LIMIT, SAME_MODE};
use crate::map::Approach;
use crate::{AssessOptions, Fit, Gaussian, Health, InferenceError, Mode, Posterior};
use rand::RngExt;
use rand_distr::StandardNormal;
use rayon::prelude::*;

impl Posterior<'_> {
    /// The maxima found from all starts, best first (converged before others); at least one. Calls and what was left
    /// unfinished go into `health`.
    pub(crate) fn maxima(
        &self,
        options: &AssessOptions,
        health: &mut Health,
    ) -> Result<Vec<Fit>, InferenceError> {
        let starts = self.starts(options);
        health.starts = starts.len();
        let (first, tried) = self.first_fit(&starts, options, health)?;
        let known = self.laplace_of_likelihood(&first).ok();
        let touching = known.as_ref().and_then(|l| Gaussian::from_hessian(&l.mean, 0.0, &l.hessian).ok());
        // Every other start is brought near a maximum; only those that are not near the first one go all the way.
        let ends: Vec<Result<Approach, InferenceError>> = starts[tried..]
            .par_iter()
            .map(|start| self.approach(self.start(start.as_deref())?, &options.search, touching.as_ref()))
            .collect();
        health.failed_starts += ends.iter().filter(|end| end.is_err()).count();
        let mut rest: Vec<Approach> = ends.into_iter().flatten().collect();
        // Settled ends first, then by cost; the sort is stable, so ties keep the order of the starts.
        rest.sort_by(|a, b| b.settled.cmp(&a.settled).then(a.cost.total_cmp(&b.cost)));
        let (mut fits, mut other) = (vec![first], Vec::new());
        for end in rest {
            if end.settled && touching.as_ref().is_some_and(|g| self.is_at(&end.z, g)) {
                health.calls = health.calls.plus(end.calls);
            } else if end.settled
                && known
                    .as_ref()
                    .is_some_and(|l| end.ln_likelihood + 1.0 < l.evidence.ln_marginal + MODE_LIMIT)
            {
                // An evidence is a mean of the likelihood, and cannot exceed its maximum: this one cannot matter.
                health.calls = health.calls.plus(end.calls);
                let parameters = self.parameters().physical(&end.z[..self.parameters().len()]);
                health.other_modes.push(Mode { parameters, ln_marginal: None });
            } else {
                other.push(end);
            }
        }
        let others: Vec<Result<Fit, InferenceError>> =
            other.into_par_iter().map(|approach| self.finish(approach, &options.search)).collect();
        health.failed_starts += others.iter().filter(|end| end.is_err()).count();
        fits.extend(others.into_iter().flatten());
        for fit in &fits {
            health.calls = health.calls.plus(fit.calls);
            health.failed_starts += usize::from(!fit.stop.converged());
        }
        fits.sort_by(|a, b| b.stop.converged().cmp(&a.stop.converged()).then(a.cost.total_cmp(&b.cost)));
        Ok(fits)
    }

    /// The fit from the first start that leads anywhere, and how many starts that took.
    fn first_fit(
        &self,
        starts: &[Option<Vec<f64>>],
        options: &AssessOptions,
        health: &mut Health,
    ) -> Result<(Fit, usize), InferenceError> {
        let mut first_error = None;
        for (k, start) in starts.iter().enumerate() {
            let fit = self
                .start(start.as_deref())
                .and_then(|z| self.approach(z, &options.search, None))
                .and_then(|near| self.finish(near, &options.search));
            match fit {
                Ok(fit) => return Ok((fit, k + 1)),
                Err(error) => {
                    health.failed_starts += 1;
                    first_error.get_or_insert(error);
                }
            }
        }
        Err(first_error.unwrap_or(InferenceError::StartSize { found: 0, expected: 1 }))
    }

    /// Whether a point of a search belongs to the maximum that `gaussian` touches.
    pub(crate) fn is_at(&self, z: &[f64], gaussian: &Gaussian) -> bool {
        let inner: Vec<f64> = self.integrated().iter().map(|&i| z[i]).collect();
        gaussian.distance(&inner) < SAME_MODE
    }

    fn starts(&self, options: &AssessOptions) -> Vec<Option<Vec<f64>>> {
        let mut starts = vec![None];
        starts.extend(options.starts.iter().cloned().map(Some));
        if self.parameters().improper().is_none() && !self.parameters().is_empty() {
            starts.extend((0..options.random_starts).map(|k| {
                let mut stream = options.streams.stream(&format!("inference/start/{k}"));
                let xi: Vec<f64> =
                    (0..self.parameters().len()).map(|_| stream.sample(StandardNormal)).collect();
                Some(self.parameters().physical(&self.parameters().from_standard_normal(&xi)))
            }));
        }
        starts
    }
}
