//! The most probable parameters.

use crate::held::Held;
use crate::settle::Settled;
use crate::{
    Calls, Gaussian, InferenceError, Method, Minimum, Objective, Posterior, Stop, TrustRegion, minimise,
};
use rijke_numerics::{Matrix, Order};
use serde::{Deserialize, Serialize};

/// Most alternations between parameters and noise before both are freed.
const STAGES: usize = 40;
/// Drop in J, nats, at which a search with the noise held ends: a tenth of a standard deviation from its minimum.
const ROUGH: f64 = 5e-3;
/// The same in the first turn, whose noise is that of a start: one standard deviation.
const FIRST_TURN: f64 = 0.5;

/// Change of ln sd at which the alternation ends: a share of its own standard deviation, which is 1/sqrt(2 n) for n data.
const SETTLED: f64 = 0.02;
/// Gauss-Newton evaluations per stage before exact Hessians take over, each of which costs as much as some p/3 of them.
const QUICK: usize = 60;

/// Where a rough search has come: within about a tenth of a standard deviation of a maximum, if it has settled.
pub(crate) struct Approach {
    pub(crate) z: Vec<f64>,
    /// The noises that the floor may explain.
    pub(crate) small: Vec<Settled>,
    pub(crate) calls: Calls,
    /// J at `z`, nats.
    pub(crate) cost: f64,
    /// ln P(D | a) at `z`.
    pub(crate) ln_likelihood: f64,
    pub(crate) settled: bool,
}

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
    /// [`InferenceError::NoStart`] if the model fails at the start, and errors that are not recoverable. A search that
    /// ends without converging is a [`Fit`] whose `stop` says so.
    pub fn map(&self, options: &MapOptions) -> Result<Fit, InferenceError> {
        let start = options.start.as_deref();
        if self.floating().is_empty() {
            return self.map_from(&self.start_alone(start)?, &options.search);
        }
        self.finish(self.approach(self.screen(start)?, &options.search, &[])?, &options.search)
    }

    /// The maximum next to where a rough search has come.
    pub(crate) fn finish(&self, near: Approach, search: &TrustRegion) -> Result<Fit, InferenceError> {
        let Approach { z, small, mut calls, .. } = near;
        let left = |calls: Calls| TrustRegion {
            max_evaluations: search.max_evaluations.saturating_sub(calls.total()).max(1),
            ..*search
        };
        if let Some(fit) = self.without(small, &z, left, &mut calls)? {
            return Ok(fit);
        }
        let mut fit = self.map_from(&z, &left(calls))?;
        calls = calls.plus(fit.calls);
        if !fit.stop.converged() {
            // Other noises may explain the residuals of one as well, which then runs to nothing.
            let vanished = self.vanished(&fit.working);
            if let Some(fit) = self.without(vanished, &fit.working, left, &mut calls)? {
                return Ok(fit);
            }
        }
        fit.calls = calls;
        Ok(fit)
    }

    /// The fit without those of the `small` noises that the floor explains: J does not fall when any of them grows from nothing. None if
    /// all of them are needed. `left` is what the calls so far leave of a search.
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
            let held = Held::new(self, whole, free);
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

    /// Brings the parameters near the maximum with the noise held, then the noise to its best there, and so on until
    /// the noise settles.
    ///
    /// Freed at once, the noise shrinks the trust region as the fit improves: J is then the logarithm of a sum of
    /// squares, concave far from the minimum. Held, it is the sum of squares itself.
    ///
    /// Ends early at a maximum that one of `known` touches.
    pub(crate) fn approach(
        &self,
        from: Approach,
        search: &TrustRegion,
        known: &[Gaussian],
    ) -> Result<Approach, InferenceError> {
        let floats = !self.floating().is_empty();
        let Approach { mut z, mut small, mut calls, mut cost, mut ln_likelihood, .. } = from;
        let (p, mut settled) = (self.parameters().len(), false);
        for turn in 0..STAGES {
            // Leave one call for the search that follows.
            let budget = search.max_evaluations.saturating_sub(calls.total() + 1);
            if budget == 0 {
                break;
            }
            // By its own matrix, which is poor at first, BFGS would stop too early.
            let loose = turn == 0 && floats && search.method != Method::Bfgs;
            let rough = if loose { FIRST_TURN } else { ROUGH };
            let (minimum, order) = self.stage(&z, search, budget, rough)?;
            calls = calls.plus(minimum.calls);
            z[..p].copy_from_slice(&minimum.z);
            settled = minimum.stop.converged();
            if settled && known.iter().any(|gaussian| self.is_at(&z, gaussian)) {
                break;
            }
            if !floats {
                cost = minimum.energy.value;
                ln_likelihood = -cost - self.parameters().ln_density(&z[..p])?.value;
                break;
            }
            let before = z[p..].to_vec();
            // The stage ended with this very call of the model.
            let prediction = self.predict(&self.parameters().physical(&z[..p]), order)?;
            small = self.settle_noise(&mut z, &prediction.values);
            self.refine_noise(&mut z, &prediction)?;
            let parts = self.parts_of(&z, prediction, Order::Value, None)?;
            (cost, ln_likelihood) = (-(parts.ln_likelihood + parts.ln_prior), parts.ln_likelihood);
            let change = before.iter().zip(&z[p..]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            if change < SETTLED || !settled {
                break;
            }
        }
        Ok(Approach { z, small, calls, cost, ln_likelihood, settled })
    }

    /// A rough search over the parameters with the noise held. Newton's exact Hessians are dear: Gauss-Newton steps go
    /// first, and mostly suffice. Also the order of derivatives to which the model was called at the end.
    fn stage(
        &self,
        z: &[f64],
        search: &TrustRegion,
        budget: usize,
        rough: f64,
    ) -> Result<(Minimum, Order), InferenceError> {
        let p = self.parameters().len();
        let held = Held::new(self, z.to_vec(), (0..p).collect());
        let rough =
            TrustRegion { tolerance: search.tolerance.max(rough), max_evaluations: budget, ..*search };
        let mut spent = Calls::default();
        if search.method == Method::Newton && budget > QUICK {
            let quick = TrustRegion { method: Method::GaussNewton, max_evaluations: QUICK, ..rough };
            let minimum = minimise(&held, &z[..p], &quick)?;
            if minimum.stop.converged() {
                return Ok((minimum, Order::First));
            }
            spent = minimum.calls;
        }
        let budget = budget - spent.total();
        let mut minimum = minimise(&held, &z[..p], &TrustRegion { max_evaluations: budget, ..rough })?;
        minimum.calls = minimum.calls.plus(spent);
        Ok((minimum, if search.method == Method::Newton { Order::Second } else { Order::First }))
    }

    /// Whether a point of a search belongs to the maximum that `gaussian` touches.
    fn is_at(&self, z: &[f64], gaussian: &Gaussian) -> bool {
        let inner: Vec<f64> = self.integrated().iter().map(|&i| z[i]).collect();
        gaussian.distance(&inner) < crate::health::SAME_MODE
    }

    /// As [`Posterior::map`], from working coordinates.
    ///
    /// # Errors
    /// As [`Posterior::map`].
    pub fn map_from(&self, start: &[f64], search: &TrustRegion) -> Result<Fit, InferenceError> {
        Ok(self.fit_of(minimise(self, start, search)?, search.method))
    }

    fn fit_of(&self, minimum: Minimum, method: Method) -> Fit {
        let sds = self.noise_sd(&minimum.z);
        let noise = self.data().groups().iter().zip(sds).map(|(g, sd)| NoiseEstimate {
            name: g.name.clone(),
            unit: g.unit.clone(),
            sd,
            floats: g.floats(),
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
