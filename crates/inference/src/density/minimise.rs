//! The minimiser: a trust region, with the exact Hessian, the Gauss-Newton matrix or a BFGS matrix.

use super::objective::{Energy, Objective};
use super::quadratic::Quadratic;
use super::stop::{Calls, Stop};
use crate::error::InferenceError;
use rijke_numerics::dot;
use rijke_numerics::{Matrix, Order};
use serde::{Deserialize, Serialize};

/// Where the second derivatives of a step come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// The exact Hessian, which may be indefinite on the way.
    Newton,
    /// First derivatives alone: [`Energy::gauss_newton`] in place of the Hessian. Cheap and quick where
    /// residuals are small or the model is nearly linear; an objective that offers none is searched by BFGS.
    GaussNewton,
    /// The matrix of Broyden, Fletcher, Goldfarb and Shanno, built from gradients; the paper's choice.
    Bfgs,
}

/// Settings of the minimiser.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrustRegion {
    /// Source of second derivatives.
    pub method: Method,
    /// Evaluations of the objective after which the search ends, whatever it has reached. It has then
    /// converged if less than 1e-3 nats are left to gain.
    pub max_evaluations: usize,
    /// The search has converged when half of g' H^-1 g, the drop in J that is left, is below this, in nats.
    /// Half the squared distance to the minimum in posterior standard deviations.
    pub tolerance: f64,
    /// First radius, in multiples of the typical change of the coordinates.
    pub first_radius: f64,
}

impl Default for TrustRegion {
    fn default() -> Self {
        Self { method: Method::Newton, max_evaluations: 2000, tolerance: 1e-18, first_radius: 1.0 }
    }
}

/// Where a search ended.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// The best point found.
    pub z: Vec<f64>,
    /// The objective there, to the order that the method uses.
    pub energy: Energy,
    /// The matrix of second derivatives that the method holds there: exact, or BFGS.
    pub hessian: Matrix,
    /// Why the search ended.
    pub stop: Stop,
    /// Accepted steps.
    pub steps: usize,
    /// Evaluations.
    pub calls: Calls,
}

/// Steps with less of the predicted drop than this are refused (More & Sorensen 1983).
const ACCEPT: f64 = 1e-4;
/// The model of the next step changes when the other one missed the last drop by less than this fraction.
const PREFER: f64 = 0.67;
/// J is summed from many terms; differences below this fraction of it are taken as rounding.
const ROUNDING: f64 = 1e-14;
/// A search that no step improves has converged if the drop that is left is below this fraction of J: the
/// noise of a model that itself iterates.
const STALL: f64 = 1e-10;
/// What is left to gain, nats, below which a search has converged if it can go no further: 0.014 posterior
/// standard deviations. The tolerance is what is aimed at; rounding of many data, or of a model that
/// iterates, may keep it out of reach.
const ENOUGH: f64 = 1e-4;
/// The same where the evaluations are used up: far below what any evidence is judged by.
const AT_THE_CAP: f64 = 1e-3;
/// Evaluations within which that gain must halve for the search to go on below it.
const PATIENCE: usize = 40;
/// Drop in J, in nats, below which the gradient alone judges steps: 1e-4 posterior standard deviations from
/// the minimum.
const POLISH: f64 = 1e-8;

/// Finds a local minimum from `start` by a trust region (More & Sorensen 1983; Nocedal & Wright, chapter 4).
///
/// The subproblem is solved by eigenvalues, so indefinite Hessians and the hard case need no special care;
/// cost O(n^3) per step beside the evaluation. The region is an ellipsoid in units of the largest
/// Gauss-Newton curvature seen (More 1978), or of [`Objective::scales`] for BFGS. Once differences of J drown
/// in rounding, steps are judged by the gradient instead, so parameters come out to more than half of the
/// digits. Never runs past `settings.max_evaluations`.
///
/// # Errors
/// [`InferenceError::Setting`] for a radius or a tolerance that is none; [`InferenceError::NoStart`] if the
/// objective fails at `start`, and any error that is not recoverable.
pub fn minimise(
    objective: &dyn Objective,
    start: &[f64],
    settings: &TrustRegion,
) -> Result<Minimum, InferenceError> {
    for (name, value, fits, need) in [
        ("first_radius", settings.first_radius, settings.first_radius > 0.0, "a number above zero"),
        ("tolerance", settings.tolerance, settings.tolerance >= 0.0, "nats, zero or more"),
    ] {
        if !fits || value.is_infinite() {
            return Err(InferenceError::Setting { name, value, need });
        }
    }
    let order = if settings.method == Method::Newton { Order::Second } else { Order::First };
    let mut search = Search::new(objective, start, settings, order)?;
    loop {
        let exact = Quadratic::new(&search.hessian, &search.energy.gradient, &search.stretch)?;
        let decrement = exact.decrement();
        if decrement <= settings.tolerance {
            return Ok(search.end(Stop::Converged { decrement }));
        }
        if decrement <= ENOUGH && search.lingers(decrement) {
            return Ok(search.end(Stop::Converged { decrement }));
        }
        if search.calls.total() >= settings.max_evaluations {
            let stop = if decrement <= AT_THE_CAP {
                Stop::Converged { decrement }
            } else {
                Stop::EvaluationCap { decrement }
            };
            return Ok(search.end(stop));
        }
        let rounding = ROUNDING * (1.0 + search.energy.value.abs());
        // So near the minimum J may drown in rounding: take Newton's step whole, and let the gradient judge
        // it. A BFGS matrix is not to be trusted that far before J does drown.
        let polishing = decrement <= if search.method == Method::Newton { POLISH } else { rounding };
        let simpler = match &search.energy.gauss_newton {
            Some(matrix) if search.method == Method::Newton && search.far && !polishing => {
                Some(Quadratic::new(matrix, &search.energy.gradient, &search.stretch)?)
            }
            _ => None,
        };
        let model = simpler.as_ref().unwrap_or(&exact);
        let (step, length, predicted) = model.step(if polishing { f64::INFINITY } else { search.radius });
        if predicted <= rounding && decrement == f64::INFINITY {
            if simpler.is_some() {
                // Gauss and Newton's matrix does not see that this is a saddle; the exact one leads away.
                search.far = false;
                continue;
            }
            return Ok(search.end(Stop::Flat { eigenvalue_ratio: exact.ratio() }));
        }
        let trial: Vec<f64> = (0..step.len()).map(|i| search.z[i] + step[i] / search.stretch[i]).collect();
        search.calls.count(order);
        let energy = match objective.evaluate(&trial, order) {
            Ok(energy) => energy,
            Err(error) if error.is_recoverable() => {
                search.calls.failed += 1;
                search.radius = 0.25 * length;
                if let Some(stop) = search.collapsed(&error.to_string()) {
                    return Ok(search.end(stop));
                }
                continue;
            }
            Err(error) => return Err(error),
        };
        if polishing {
            let left = exact.decrement_of(&energy.gradient, &search.stretch);
            if left < 0.5 * decrement {
                search.accept(trial, energy);
                continue;
            }
            return Ok(search.end(Stop::Converged { decrement }));
        }
        let actual = search.energy.value - energy.value;
        search.choose_model(&step, actual);
        let ratio = actual / predicted;
        if ratio < 0.25 {
            search.radius = if ratio < -1.0 { 0.1 * length } else { 0.25 * length };
        } else if ratio > 0.75 && length > 0.8 * search.radius {
            search.radius *= 2.0;
        }
        if search.method == Method::Bfgs {
            // A refused point still tells the curvature along the step.
            search.update_bfgs(&trial, &energy.gradient);
        }
        if ratio > ACCEPT {
            search.accept(trial, energy);
        } else if let Some(stop) = search.collapsed("none makes the posterior density larger") {
            let drowned = decrement <= ENOUGH.max(STALL * (1.0 + search.energy.value.abs()));
            return Ok(search.end(if drowned { Stop::Converged { decrement } } else { stop }));
        }
    }
}

struct Search {
    z: Vec<f64>,
    energy: Energy,
    hessian: Matrix,
    /// Scaled coordinate = stretch times coordinate.
    stretch: Vec<f64>,
    radius: f64,
    steps: usize,
    calls: Calls,
    method: Method,
    /// Steps come from the Gauss-Newton matrix, because it foretells J better than the exact Hessian does.
    far: bool,
    /// BFGS has met no curvature yet, and still holds the guess from the scales.
    untaught: bool,
    /// What was left to gain when it last halved, the evaluations then, and J.
    halved: (f64, usize, f64),
}

impl Search {
    fn new(
        objective: &dyn Objective,
        start: &[f64],
        settings: &TrustRegion,
        order: Order,
    ) -> Result<Self, InferenceError> {
        let mut calls = Calls::default();
        calls.count(order);
        let energy = objective.evaluate(start, order).map_err(|source| InferenceError::NoStart {
            at: objective.named_point(start),
            source: Box::new(source),
        })?;
        let mut scales = objective.scales();
        for (scale, z) in scales.iter_mut().zip(start) {
            if !scale.is_finite() {
                // Nothing is known but the start: expect a change of its own size (More 1978).
                *scale = if *z == 0.0 { 1.0 } else { z.abs() };
            }
        }
        let mut search = Self {
            z: start.to_vec(),
            hessian: Matrix::diagonal(&scales.iter().map(|s| 1.0 / (s * s)).collect::<Vec<_>>()),
            energy: Energy::default(),
            stretch: vec![0.0; start.len()],
            radius: 0.0,
            steps: 0,
            calls,
            method: settings.method,
            far: true,
            untaught: true,
            halved: (f64::INFINITY, 0, f64::INFINITY),
        };
        if energy.gauss_newton.is_none() && search.method == Method::GaussNewton {
            search.method = Method::Bfgs;
        }
        if search.method == Method::Bfgs {
            search.stretch = scales.iter().map(|s| 1.0 / s).collect();
        }
        search.accept(start.to_vec(), energy);
        search.steps = 0;
        let size: f64 = search.stretch.iter().zip(&scales).map(|(d, s)| (d * s).powi(2)).sum();
        search.radius = settings.first_radius * size.sqrt();
        Ok(search)
    }

    /// True if what is left to gain has not halved for [`PATIENCE`] evaluations, in which J fell by less than
    /// that: along a flat valley the gain stays small, but J goes on falling.
    fn lingers(&mut self, decrement: f64) -> bool {
        let (now, value) = (self.calls.total(), self.energy.value);
        let (before, then, energy) = self.halved;
        if decrement < 0.5 * before || (now - then > PATIENCE && energy - value > decrement) {
            self.halved = (decrement, now, value);
        }
        now - self.halved.1 > PATIENCE
    }

    fn accept(&mut self, z: Vec<f64>, energy: Energy) {
        self.z = z;
        if self.method != Method::Bfgs {
            let shape = energy.gauss_newton.as_ref().unwrap_or(&energy.hessian);
            for (i, d) in self.stretch.iter_mut().enumerate() {
                *d = d.max(shape[(i, i)].abs().sqrt());
                if *d == 0.0 {
                    *d = 1.0;
                }
            }
            let second = if self.method == Method::Newton { &energy.hessian } else { shape };
            self.hessian = second.clone();
        }
        self.energy = energy;
        self.steps += 1;
    }

    /// Keeps or changes the source of the next step, by which of the two foretold the last drop better. Far
    /// from the minimum the Gauss-Newton matrix often does, near it the Hessian (Dennis, Gay & Welsch 1981,
    /// NL2SOL).
    fn choose_model(&mut self, step: &[f64], actual: f64) {
        let Some(simpler) = &self.energy.gauss_newton else { return };
        let step: Vec<f64> = step.iter().zip(&self.stretch).map(|(s, d)| s / d).collect();
        let linear = -dot(&self.energy.gradient, &step);
        let miss = |h: &Matrix| (linear - 0.5 * h.quadratic(&step) - actual).abs();
        let (with_simpler, with_exact) = (miss(simpler), miss(&self.hessian));
        if self.far && with_exact < PREFER * with_simpler {
            self.far = false;
        } else if !self.far && with_simpler < PREFER * with_exact {
            self.far = true;
        }
    }

    /// The update with Powell's damping, so that the matrix stays positive definite without a line search.
    fn update_bfgs(&mut self, trial: &[f64], gradient: &[f64]) {
        let n = trial.len();
        let step: Vec<f64> = (0..n).map(|i| trial[i] - self.z[i]).collect();
        let mut change: Vec<f64> = (0..n).map(|i| gradient[i] - self.energy.gradient[i]).collect();
        let along = dot(&step, &change);
        if self.untaught && along > 0.0 {
            // Scale the guess to the curvature met on the first step (Nocedal & Wright, equation 6.20).
            let guess = Matrix::from_fn(n, n, |i, j| self.hessian[(i, j)] / self.hessian[(i, i)]);
            let inverse: Vec<f64> = (0..n).map(|i| 1.0 / self.hessian[(i, i)]).collect();
            let size: f64 = (0..n).map(|i| change[i] * change[i] * inverse[i]).sum();
            self.hessian = Matrix::from_fn(n, n, |i, j| guess[(i, j)] * self.hessian[(i, i)] * size / along);
            self.untaught = false;
        }
        let bent = self.hessian.times(&step);
        let curvature = dot(&step, &bent);
        if along < 0.2 * curvature {
            let mix = 0.8 * curvature / (curvature - along);
            for (c, b) in change.iter_mut().zip(&bent) {
                *c = mix * *c + (1.0 - mix) * b;
            }
        }
        let along = dot(&step, &change);
        if along > 0.0 && curvature > 0.0 {
            self.hessian = Matrix::from_fn(n, n, |i, j| {
                self.hessian[(i, j)] - bent[i] * bent[j] / curvature + change[i] * change[j] / along
            });
        }
    }

    fn collapsed(&self, reason: &str) -> Option<Stop> {
        let size: f64 = self.z.iter().zip(&self.stretch).map(|(z, d)| (z * d).powi(2)).sum();
        (self.radius <= 1e-15 * size.sqrt().max(1e-3)).then(|| Stop::Blocked { reason: reason.to_owned() })
    }

    fn end(self, stop: Stop) -> Minimum {
        let Self { z, energy, hessian, steps, calls, .. } = self;
        Minimum { z, energy, hessian, stop, steps, calls }
    }
}
