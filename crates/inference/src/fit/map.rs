//! The most probable parameters.

use super::approach::Approach;
use super::conditional::Conditional;
use super::posterior::Posterior;
use super::settle::Settled;
use crate::density::{Calls, Method, Minimum, Objective, Stop, TrustRegion, minimise};
use crate::error::InferenceError;
use rijke_numerics::{Matrix, Order};
use serde::{Deserialize, Serialize};

/// Settings of [`Posterior::map`].
#[derive(Clone, Debug, PartialEq)]
pub struct MapOptions {
    /// The minimiser; [`Method::Bfgs`] for the paper's algorithm.
    pub search: TrustRegion,
    /// Physical parameters to start from; the centre of the prior if none.
    pub start: Option<Vec<f64>>,
}

/// The maximum of a posterior, as far as the search has come: look at `stop`.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Working coordinates: those of the parameters, then ln sd of each noise that floats.
    pub working: Vec<f64>,
    /// Physical parameters.
    pub parameters: Vec<f64>,
    /// Standard deviation of every group of noise.
    pub noise: Vec<NoiseEstimate>,
    /// J at the end, nats.
    pub cost: f64,
    /// The matrix of second derivatives of J that the search held at the end (BFGS, or exact).
    pub search_hessian: Matrix,
    /// Which of the two it is.
    pub method: Method,
    /// Why the search ended.
    pub stop: Stop,
    /// Accepted steps.
    pub steps: usize,
    /// Calls of the model.
    pub calls: Calls,
}

/// The standard deviation of one group of noise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NoiseEstimate {
    /// Name of the group.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Standard deviation, without the floor.
    pub sd: f64,
    /// True if the data chose it.
    pub floats: bool,
    /// What few data leave unknown of it ([`crate::Few`]): the factor on its variance, and the variance of
    /// the logarithm of that. Nothing until it was found: [`Posterior::assess`] does so, a fit alone does
    /// not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub few: Option<[f64; 2]>,
}

/// Shares of the variance of the floor from which a noise begins again.
const REGROWN: [f64; 3] = [0.1, 1.0, 0.01];
/// First radius of a search that is not to step over the best of a noise.
const SHORT: f64 = 0.1;

impl NoiseEstimate {
    /// The [`few`](Self::few) of a noise of which nothing is unknown, such as one that was stated.
    pub const KNOWN: [f64; 2] = [1.0, 0.0];

    /// [`few`](Self::few), or that of a noise of which nothing is unknown where it was not found.
    #[must_use]
    pub fn unknown(&self) -> [f64; 2] {
        self.few.unwrap_or(Self::KNOWN)
    }
}

impl Default for MapOptions {
    /// Exact Newton steps from the centre of the prior.
    fn default() -> Self {
        Self { search: TrustRegion::default(), start: None }
    }
}

impl MapOptions {
    /// The paper's algorithm: BFGS with the analytic gradient.
    ///
    /// It stops at 1e-12 nats by its own matrix, about 1e-6 posterior standard deviations from the maximum.
    #[must_use]
    pub fn bfgs() -> Self {
        Self {
            search: TrustRegion { method: Method::Bfgs, tolerance: 1e-12, ..TrustRegion::default() },
            start: None,
        }
    }

    /// The same settings from another start, in physical values.
    #[must_use]
    pub fn from(self, start: &[f64]) -> Self {
        Self { start: Some(start.to_vec()), ..self }
    }
}

impl Posterior<'_> {
    /// Finds a local maximum of the posterior over parameters and floating noise.
    ///
    /// # Errors
    /// [`InferenceError::NoStart`] if the model fails at the start, and errors that are not recoverable. A
    /// search that ends without converging is a [`Fit`] whose `stop` says so.
    pub fn map(&self, options: &MapOptions) -> Result<Fit, InferenceError> {
        let start = options.start.as_deref();
        if self.floating().is_empty() {
            return self.map_from(&self.start_alone(start)?, &options.search);
        }
        self.finish(self.approach(self.screen(start)?, &options.search, &[])?, &options.search)
    }

    /// The maximum next to where a rough search has come, or the larger one at which inferred noises are as
    /// large as the residuals ask for.
    pub(crate) fn finish(&self, near: Approach, search: &TrustRegion) -> Result<Fit, InferenceError> {
        let left = |calls: Calls| TrustRegion {
            max_evaluations: search.max_evaluations.saturating_sub(calls.total()).max(1),
            ..*search
        };
        let fit = self.next_to(near, left)?;
        if !self.infers_noise() {
            return Ok(fit);
        }
        let mut raised = fit.working.clone();
        let predicted = self.predict(&fit.parameters, Order::Value)?.values;
        if !self.raise_noise(&mut raised, &predicted) {
            return Ok(fit);
        }
        // A search that used up its evaluations had too small a noise.
        let more = if fit.stop.converged() { left(fit.calls) } else { *search };
        // The model may fail there; what was found stands.
        let Ok(other) = self.map_from(&raised, &more) else { return Ok(fit) };
        let calls = fit.calls.plus(other.calls);
        let better = other.stop.converged() && (other.cost < fit.cost || !fit.stop.converged());
        Ok(Fit { calls, ..if better { other } else { fit } })
    }

    /// The maximum next to where a rough search has come; `left` is what the calls so far leave of a search.
    fn next_to(
        &self,
        near: Approach,
        left: impl Fn(Calls) -> TrustRegion + Copy,
    ) -> Result<Fit, InferenceError> {
        let Approach { z, small, mut calls, cost, .. } = near;
        let without = self.without(small, &z, left, &mut calls)?;
        // Where measured errors differ much, parameters that follow the most precise data need no noise, and
        // yet may be far less probable than others that do.
        let without = match without {
            Some(fit) if fit.cost <= cost => return Ok(fit),
            other => other,
        };
        let fit = self.map_from(&z, &left(calls))?;
        calls = calls.plus(fit.calls);
        if let Some(without) = without {
            let better = fit.stop.converged() && fit.cost < without.cost;
            return Ok(Fit { calls, ..if better { fit } else { without } });
        }
        if !fit.stop.converged() {
            // Other noises may explain the residuals of one as well, which then runs to nothing.
            let vanished = self.vanished(&fit.working);
            if let Some(fit) = self.without(vanished, &fit.working, left, &mut calls)? {
                return Ok(fit);
            }
            if let Some(fit) = self.regrown(&fit.working, left, &mut calls)? {
                return Ok(fit);
            }
        }
        Ok(Fit { calls, ..fit })
    }

    /// The fit from where noises have run to nothing that are needed: one long step has led from above their
    /// best to where J is level. They begin again at shares of the floor, from which J still falls to it.
    fn regrown(
        &self,
        level: &[f64],
        left: impl Fn(Calls) -> TrustRegion + Copy,
        calls: &mut Calls,
    ) -> Result<Option<Fit>, InferenceError> {
        let mut near = level.to_vec();
        for share in REGROWN {
            let vanished = self.vanished(&near);
            if vanished.is_empty() {
                return Ok(None);
            }
            for noise in &vanished {
                near[noise.coordinate] = noise.grown_to(share);
            }
            let search = TrustRegion { first_radius: SHORT, ..left(*calls) };
            let fit = match self.map_from(&near, &search) {
                Err(InferenceError::NoStart { .. }) => return Ok(None),
                other => other?,
            };
            *calls = calls.plus(fit.calls);
            if fit.stop.converged() {
                return Ok(Some(Fit { calls: *calls, ..fit }));
            }
            if let Some(fit) = self.without(self.vanished(&fit.working), &fit.working, left, calls)? {
                return Ok(Some(fit));
            }
            near = fit.working;
        }
        Ok(None)
    }

    /// The fit without those of the `small` noises that the floor explains: J does not fall when any of them
    /// grows from nothing. None if all of them are needed. `left` is what the calls so far leave of a search.
    ///
    /// J levels off towards ln sd = -infinity; a search that runs there would never end in finite steps.
    fn without(
        &self,
        mut small: Vec<Settled>,
        near: &[f64],
        left: impl Fn(Calls) -> TrustRegion,
        calls: &mut Calls,
    ) -> Result<Option<Fit>, InferenceError> {
        while !small.is_empty() {
            let search = left(*calls);
            let mut whole = near.to_vec();
            for noise in &small {
                whole[noise.coordinate] = noise.ln_sd;
            }
            let free: Vec<usize> =
                (0..self.size()).filter(|i| small.iter().all(|s| s.coordinate != *i)).collect();
            let from: Vec<f64> = free.iter().map(|&i| near[i]).collect();
            let held = Conditional::new(self, whole, free);
            // One call is for the slopes below.
            let budget = search.max_evaluations.saturating_sub(1).max(1);
            let search_without = TrustRegion { max_evaluations: budget, ..search };
            // A floor of low rank cannot stand alone: the noise is needed, however small.
            let minimum = match minimise(&held, &from, &search_without) {
                Err(InferenceError::NoStart { .. } | InferenceError::SingularCovariance { .. }) => {
                    return Ok(None);
                }
                other => other?,
            };
            let z = held.filled(&minimum.z);
            *calls = calls.plus(minimum.calls);
            calls.count(Order::First);
            let slopes = self.evaluate(&z, Order::First)?.gradient;
            let before = small.len();
            small.retain(|s| slopes[s.coordinate] >= 0.0);
            if small.len() < before {
                continue;
            }
            if !minimum.stop.converged() {
                return Ok(None);
            }
            let n = self.size();
            let mut hessian = Matrix::zeros(n, n);
            for (k, &i) in held.free.iter().enumerate() {
                for (l, &j) in held.free.iter().enumerate() {
                    hessian[(i, j)] = minimum.hessian[(k, l)];
                }
            }
            let end = Minimum { z, hessian, calls: *calls, ..minimum };
            return Ok(Some(self.fit_of(end, search.method)));
        }
        Ok(None)
    }

    /// As [`Posterior::map`], from working coordinates: those of the parameters, then ln sd of each noise
    /// that floats.
    ///
    /// # Errors
    /// As [`Posterior::map`], and [`InferenceError::StartSize`] for another number of them.
    pub fn map_from(&self, start: &[f64], search: &TrustRegion) -> Result<Fit, InferenceError> {
        if start.len() != self.size() {
            return Err(InferenceError::StartSize { found: start.len(), expected: self.size() });
        }
        Ok(self.fit_of(minimise(self, start, search)?, search.method))
    }

    fn fit_of(&self, minimum: Minimum, method: Method) -> Fit {
        let sds = self.noise_sd(&minimum.z);
        let noise = self.data().groups().iter().zip(sds).map(|(g, sd)| NoiseEstimate {
            name: g.name.clone(),
            unit: g.unit.clone(),
            sd,
            floats: g.floats(),
            few: (!g.floats()).then_some(NoiseEstimate::KNOWN),
        });
        Fit {
            parameters: self.parameters().physical(&minimum.z),
            noise: noise.collect(),
            cost: minimum.energy.value,
            search_hessian: minimum.hessian,
            method,
            stop: minimum.stop,
            steps: minimum.steps,
            calls: minimum.calls,
            working: minimum.z,
        }
    }
}
