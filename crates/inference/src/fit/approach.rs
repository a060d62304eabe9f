//! From a start to the neighbourhood of a maximum, in turns of parameters and noise.

use super::conditional::Conditional;
use super::posterior::Posterior;
use super::settle::Settled;
use crate::density::{Calls, Gaussian, Method, Minimum, SAME_MODE, TrustRegion, minimise};
use crate::error::InferenceError;
use crate::problem::Prediction;
use rijke_numerics::Order;

/// Most alternations between parameters and noise before both are freed.
const STAGES: usize = 40;
/// Drop in J, nats, at which a search with the noise held ends: a tenth of a standard deviation from its
/// minimum.
const ROUGH: f64 = 5e-3;
/// The same in the first turn, whose noise is that of a start: one standard deviation.
const FIRST_TURN: f64 = 0.5;

/// Change of ln sd at which the alternation ends: a share of its own standard deviation, which is 1/sqrt(2 n)
/// for n data.
const SETTLED: f64 = 0.02;
/// Nats within which the noise of a turn is the best one.
const REFINED: f64 = 1e-4;
/// The share of floated noises that [`Posterior::with_less_noise`] leaves.
const LESS: f64 = 0.05;
/// Gauss-Newton evaluations per stage before exact Hessians take over, each of which costs as much as some
/// p/3 of them.
const QUICK: usize = 60;
/// Evaluations of the first turn where noises are inferred. A search that needs more may have too small a
/// noise, which [`Posterior::raised`] raises.
const HELD: usize = 3 * QUICK;

/// Where a rough search has come: within about a tenth of a standard deviation of a maximum, if it has
/// settled.
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

impl Approach {
    /// The same after its calls were counted elsewhere.
    pub(crate) fn counted(self) -> Self {
        Self { calls: Calls::default(), ..self }
    }
}

impl Posterior<'_> {
    /// Where a search from `start` begins: the floating noise is set to the residuals there. Costs one value
    /// of the model.
    pub(crate) fn screen(&self, start: Option<&[f64]>) -> Result<Approach, InferenceError> {
        let (mut z, prediction) = self.start(start)?;
        let small = self.settle_noise(&mut z, &prediction.values);
        let calls = Calls { value: 1, ..Calls::default() };
        let parts = self.parts_of(&z, prediction, Order::Value, None);
        let (cost, ln_likelihood) = match parts {
            Ok(parts) => (-(parts.ln_likelihood + parts.ln_prior), parts.ln_likelihood),
            // A noise set to small residuals may leave a singular covariance, which a search gets away from.
            Err(error) if error.is_recoverable() => (f64::INFINITY, f64::NEG_INFINITY),
            Err(error) => return Err(error),
        };
        let cost = if cost.is_nan() { f64::INFINITY } else { cost };
        Ok(Approach { z, small, calls, cost, ln_likelihood, settled: false })
    }

    /// Brings the parameters near the maximum with the noise held, then the noise to its best there, and so
    /// on until the noise settles.
    ///
    /// Freed at once, the noise shrinks the trust region as the fit improves: J is then the logarithm of a
    /// sum of squares, concave far from the minimum. Conditional, it is the sum of squares itself.
    ///
    /// Ends early at a maximum that one of `known` touches.
    pub(crate) fn approach(
        &self,
        from: Approach,
        search: &TrustRegion,
        known: &[Gaussian],
    ) -> Result<Approach, InferenceError> {
        let floats = !self.floating().is_empty();
        let inferred = self.infers_noise();
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
            let budget = if turn == 0 && inferred { budget.min(HELD) } else { budget };
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
            self.refine_noise(&mut z, &prediction, &before, REFINED)?;
            let raised = !settled && self.raised(&mut z, &prediction);
            let parts = self.parts_of(&z, prediction, Order::Value, None)?;
            (cost, ln_likelihood) = (-(parts.ln_likelihood + parts.ln_prior), parts.ln_likelihood);
            let change = before.iter().zip(&z[p..]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            if change < SETTLED || !(settled || raised) {
                break;
            }
        }
        Ok(Approach { z, small, calls, cost, ln_likelihood, settled })
    }

    /// Raises the inferred noises in `z` that lie far below the residuals, if J falls by it; whether it did.
    /// With them chi-squared is so steep that a search may not end.
    fn raised(&self, z: &mut [f64], prediction: &Prediction) -> bool {
        let cost = |z: &[f64]| {
            let values = prediction.values.clone();
            let parts = self.parts_of(z, Prediction { values, ..Prediction::default() }, Order::Value, None);
            parts.map_or(f64::INFINITY, |parts| -(parts.ln_likelihood + parts.ln_prior))
        };
        let mut higher = z.to_vec();
        let raised = self.raise_noise(&mut higher, &prediction.values) && cost(&higher) < cost(z);
        if raised {
            z.copy_from_slice(&higher);
        }
        raised
    }

    /// The parameters (physical) that are most probable if floated noises are far smaller than at `working`,
    /// the coordinates of a fit; none where no noise floats, or if the model fails.
    ///
    /// A floated noise that is large hides what the data could tell, so that parameters stay at their priors,
    /// residuals stay large, and the noise with them: a maximum. There may be another, at which parameters
    /// have left their priors and the noise is small. A search from here finds it.
    pub(crate) fn with_less_noise(&self, working: &[f64]) -> Option<Vec<f64>> {
        let p = self.parameters().len();
        let floats = |group: &usize| self.data().groups()[*group].floats();
        let mut whole = working.to_vec();
        let floated: Vec<usize> =
            (0..self.floating().len()).filter(|k| floats(&self.floating()[*k])).collect();
        if floated.is_empty() || p == 0 {
            return None;
        }
        floated.iter().for_each(|k| whole[p + k] += LESS.ln());
        let held = Conditional::new(self, whole, (0..p).collect());
        let quick = TrustRegion {
            method: Method::GaussNewton,
            max_evaluations: QUICK,
            tolerance: FIRST_TURN,
            ..TrustRegion::default()
        };
        let minimum = minimise(&held, &working[..p], &quick).ok()?;
        Some(self.parameters().physical(&minimum.z))
    }

    /// A rough search over the parameters with the noise held. Newton's exact Hessians are dear: Gauss-Newton
    /// steps go first, and mostly suffice. Also the order of derivatives to which the model was called at the
    /// end.
    fn stage(
        &self,
        z: &[f64],
        search: &TrustRegion,
        budget: usize,
        rough: f64,
    ) -> Result<(Minimum, Order), InferenceError> {
        let p = self.parameters().len();
        let held = Conditional::new(self, z.to_vec(), (0..p).collect());
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
        gaussian.distance(&inner) < SAME_MODE
    }
}
