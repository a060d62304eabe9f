//! The cost J of a model with data: minus ln P(D|a) P(a), with exact derivatives.

use super::memory::Memory;
use crate::covariance::{Block, Factor, Likelihood, add_corner};
use crate::density::{Energy, Objective};
use crate::error::InferenceError;
use crate::problem::{Data, Forward, NoiseMode, Parameters, Prediction};
use rayon::prelude::*;
use rijke_numerics::{InOrder, Matrix, Order};
use std::f64::consts::PI;

/// A model, its data and its prior: the unnormalised posterior density. Minus its logarithm is the cost J of
/// equation (4), with the halves and determinants.
///
/// Coordinates: the working coordinates of the parameters, then ln sd of every noise that floats or is
/// inferred. Cost of [`Objective::evaluate`]: one call of the model and, for each block of n data, O(n^3)
/// with floating noise and O(n^2 p) without.
pub struct Posterior<'a> {
    forward: &'a dyn Forward,
    data: &'a Data,
    parameters: &'a Parameters,
    /// For each coordinate after the parameters, the group of noise.
    floating: Vec<usize>,
    /// Factors of the covariance, if nothing floats.
    fixed: Option<Vec<Factor>>,
    /// Place of the first datum of each block.
    firsts: Vec<usize>,
    memory: Memory,
}

/// The cost in its parts, at one point.
#[derive(Clone, Debug)]
pub(crate) struct Parts {
    pub(crate) ln_likelihood: f64,
    pub(crate) ln_prior: f64,
    pub(crate) gradient: Vec<f64>,
    /// Second derivatives of -ln likelihood: products of first derivatives of the prediction (and of the
    /// noise).
    pub(crate) gauss_newton: Matrix,
    /// Second derivatives of -ln likelihood: residual times second derivatives of the prediction.
    pub(crate) curvature: Matrix,
    /// Second derivatives of -ln prior.
    pub(crate) prior: Matrix,
    pub(crate) prediction: Prediction,
}

impl<'a> Posterior<'a> {
    /// Brings a model together with data and prior.
    ///
    /// # Errors
    /// [`InferenceError::SingularCovariance`] if nothing floats and a covariance is not positive definite.
    pub fn new(
        forward: &'a dyn Forward,
        data: &'a Data,
        parameters: &'a Parameters,
    ) -> Result<Self, InferenceError> {
        let floating: Vec<usize> = (0..data.groups().len()).filter(|&g| data.groups()[g].floats()).collect();
        let mut next = 0;
        let firsts = data.observations().iter().map(|o| {
            let first = next;
            next += o.values.len();
            first
        });
        let mut posterior = Self {
            forward,
            data,
            parameters,
            floating,
            fixed: None,
            firsts: firsts.collect(),
            memory: Memory::default(),
        };
        if posterior.floating.is_empty() {
            posterior.fixed = Some(posterior.factors(&posterior.parameters.centre())?);
        }
        Ok(posterior)
    }

    /// The model.
    #[must_use]
    pub fn forward(&self) -> &'a dyn Forward {
        self.forward
    }

    /// The data.
    #[must_use]
    pub fn data(&self) -> &'a Data {
        self.data
    }

    /// The parameters.
    #[must_use]
    pub fn parameters(&self) -> &'a Parameters {
        self.parameters
    }

    /// For each coordinate after the parameters, the index of its group of noise.
    #[must_use]
    pub fn floating(&self) -> &[usize] {
        &self.floating
    }

    /// The standard deviation of every group of noise at the point `z`, of the size of this posterior.
    #[must_use]
    pub fn noise_sd(&self, z: &[f64]) -> Vec<f64> {
        let mut sds: Vec<f64> = self
            .data
            .groups()
            .iter()
            .map(|g| if let NoiseMode::Fixed { sd } = g.mode { sd } else { f64::NAN })
            .collect();
        for (&g, ln_sd) in self.floating.iter().zip(&z[self.parameters.len()..]) {
            sds[g] = ln_sd.exp();
        }
        sds
    }

    /// The covariance of block `k` with the standard deviations `sds`, as a dense matrix.
    ///
    /// # Panics
    /// If there is no block `k`, or `sds` has fewer numbers than there are groups.
    #[must_use]
    pub fn covariance(&self, k: usize, sds: &[f64]) -> Matrix {
        self.data.covariance(k, sds)
    }

    /// Calls the model, unless it was called for the same a moment ago, and checks the sizes of what it
    /// returns.
    ///
    /// # Errors
    /// Those of the model, [`InferenceError::Shape`], and [`InferenceError::NotFinite`] for a prediction that
    /// is not finite.
    pub fn predict(&self, values: &[f64], order: Order) -> Result<Prediction, InferenceError> {
        let highest = order.min(self.forward.highest_order());
        if let Some(known) = self.memory.recall(values, highest) {
            return Ok(known);
        }
        let prediction = self.forward.predict(values, highest)?;
        let (m, p) = (self.data.size(), self.parameters.len());
        let check = |what, found, expected| {
            if found == expected { Ok(()) } else { Err(InferenceError::Shape { what, found, expected }) }
        };
        check("a prediction", prediction.values.len(), m)?;
        if order >= Order::First {
            check("a jacobian", prediction.jacobian.as_slice().len(), m * p)?;
        }
        if highest == Order::Second {
            check("a curvature", prediction.curvature.len(), m * p * (p + 1) / 2)?;
        }
        match prediction.values.iter().find(|v| !v.is_finite()) {
            Some(&value) => Err(InferenceError::NotFinite { value, at: self.parameters.in_words(values) }),
            None => {
                self.memory.keep(values, highest, &prediction);
                Ok(prediction)
            }
        }
    }

    /// J in its parts.
    pub(crate) fn parts(&self, z: &[f64], order: Order) -> Result<Parts, InferenceError> {
        self.parts_with(z, order, None)
    }

    /// As [`Posterior::parts`]; with `held`, the factors of every covariance, the noise is held and has no
    /// derivatives.
    pub(crate) fn parts_with(
        &self,
        z: &[f64],
        order: Order,
        held: Option<&[Factor]>,
    ) -> Result<Parts, InferenceError> {
        let p = self.parameters.len();
        // Before the model is called: a point beyond a bound must not reach it.
        self.parameters.ln_density(&z[..p])?;
        let maps: Vec<[f64; 3]> = self.parameters.list().iter().zip(z).map(|(q, &z)| q.physical(z)).collect();
        let values: Vec<f64> = maps.iter().map(|m| m[0]).collect();
        let mut prediction = self.predict(&values, order)?;
        let (rows, first) = (prediction.values.len(), self.forward.highest_order() == Order::First);
        if order == Order::Second && first && maps.iter().any(|m| m[2] != 0.0) {
            // The coordinates bend although the model has no second derivatives.
            prediction.curvature = vec![0.0; rows * p * (p + 1) / 2];
        }
        let bends = !prediction.curvature.is_empty();
        to_working(&mut prediction, &maps, if bends { order } else { order.min(Order::First) });
        self.parts_of(z, prediction, order, held)
    }

    /// J in its parts for a prediction, with derivatives in working coordinates, that was made at `z`.
    pub(crate) fn parts_of(
        &self,
        z: &[f64],
        prediction: Prediction,
        order: Order,
        held: Option<&[Factor]>,
    ) -> Result<Parts, InferenceError> {
        let (p, n) = (self.parameters.len(), self.size());
        let prior = self.parameters.ln_density(&z[..p])?;
        let sds = self.noise_sd(z);
        let mut parts = Parts::new(n, prediction);
        parts.ln_prior = prior.value;
        for i in 0..p {
            parts.gradient[i] = -prior.gradient[i];
            for j in 0..p {
                parts.prior[(i, j)] = -prior.hessian[(i, j)];
            }
        }
        self.add_prior_of_noise(&z[p..], p, &mut parts);
        let blocks = self.blocks(&parts.prediction, p, &sds, order, held)?;
        for block in &blocks {
            parts.add(block);
        }
        Ok(parts)
    }

    /// What every block adds, with derivatives in the first `p` parameters (all or none) and the noise,
    /// unless it is held.
    pub(super) fn blocks(
        &self,
        prediction: &Prediction,
        p: usize,
        sds: &[f64],
        order: Order,
        held: Option<&[Factor]>,
    ) -> Result<Vec<Block>, InferenceError> {
        let known = held.or(self.fixed.as_deref());
        let block = |k: usize| {
            let fresh;
            let factor = match known {
                Some(factors) => &factors[k],
                None => {
                    fresh = Factor::new(self.data, k, sds)?;
                    &fresh
                }
            };
            let likelihood = Likelihood {
                observation: &self.data.observations()[k],
                noises: self.data.noises(k),
                first: self.firsts[k],
                prediction,
                parameters: p,
                floating: if known.is_some() { &[] } else { &self.floating },
                sds,
            };
            Ok(likelihood.block(factor, order))
        };
        // In parallel, and later added up in order.
        let count = self.data.observations().len();
        if order == Order::Value {
            (0..count).map(block).collect()
        } else {
            (0..count).into_par_iter().with_min_len(4).map(block).in_order()
        }
    }

    /// J as a function of the floating noise at `z`, for a prediction without derivatives.
    pub(crate) fn noise_energy(
        &self,
        z: &[f64],
        prediction: &Prediction,
        order: Order,
    ) -> Result<Energy, InferenceError> {
        let (p, n) = (self.parameters.len(), self.floating.len());
        let mut parts = Parts::new(n, Prediction::default());
        self.add_prior_of_noise(&z[p..], 0, &mut parts);
        for block in &self.blocks(prediction, 0, &self.noise_sd(z), order, None)? {
            parts.add(block);
        }
        parts.energy(&|| self.named_point(z), order, true)
    }

    /// Adds the priors of inferred noise, whose coordinates start at `first`.
    fn add_prior_of_noise(&self, noise: &[f64], first: usize, parts: &mut Parts) {
        for (k, median, ln_sd) in self.inferred() {
            let t = (noise[k] - median.ln()) / ln_sd;
            parts.ln_prior -= 0.5 * t * t + ln_sd.ln() + 0.5 * (2.0 * PI).ln();
            parts.gradient[first + k] += t / ln_sd;
            parts.prior[(first + k, first + k)] = 1.0 / (ln_sd * ln_sd);
        }
    }

    /// The factors of all covariances with the noise at `z`.
    pub(crate) fn factors(&self, z: &[f64]) -> Result<Vec<Factor>, InferenceError> {
        let sds = self.noise_sd(z);
        (0..self.data.observations().len()).map(|k| Factor::new(self.data, k, &sds)).collect()
    }

    /// J with derivatives; see [`Posterior::parts_with`].
    pub(crate) fn energy(
        &self,
        z: &[f64],
        order: Order,
        held: Option<&[Factor]>,
    ) -> Result<Energy, InferenceError> {
        // The noise's own second derivatives are formed to second order only.
        let whole = order == Order::Second || held.is_some() || self.floating.is_empty();
        self.parts_with(z, order, held)?.energy(&|| self.named_point(z), order, whole)
    }
}

impl Parts {
    fn new(n: usize, prediction: Prediction) -> Self {
        Self {
            ln_likelihood: 0.0,
            ln_prior: 0.0,
            gradient: vec![0.0; n],
            gauss_newton: Matrix::zeros(n, n),
            curvature: Matrix::zeros(n, n),
            prior: Matrix::zeros(n, n),
            prediction,
        }
    }

    fn add(&mut self, block: &Block) {
        self.ln_likelihood += block.ln_likelihood;
        for (to, from) in self.gradient.iter_mut().zip(&block.gradient) {
            *to += from;
        }
        add_corner(&mut self.gauss_newton, &block.gauss_newton);
        add_corner(&mut self.curvature, &block.curvature);
    }

    /// J `at` a point; with `whole`, the Gauss-Newton matrix has been formed for all coordinates.
    fn energy(self, at: &dyn Fn() -> String, order: Order, whole: bool) -> Result<Energy, InferenceError> {
        let value = -(self.ln_likelihood + self.ln_prior);
        let bad = || InferenceError::NotFinite { value, at: at() };
        if !value.is_finite() || self.gradient.iter().any(|g| !g.is_finite()) {
            return Err(bad());
        }
        let mut energy = Energy { value, ..Energy::default() };
        if order == Order::Value {
            return Ok(energy);
        }
        energy.gradient = self.gradient;
        let gauss_newton = self.gauss_newton.plus(1.0, &self.prior);
        if order == Order::Second {
            energy.hessian = gauss_newton.plus(1.0, &self.curvature);
            if energy.hessian.as_slice().iter().any(|h| !h.is_finite()) {
                return Err(bad());
            }
        }
        energy.gauss_newton = whole.then_some(gauss_newton);
        Ok(energy)
    }
}

impl Objective for Posterior<'_> {
    fn size(&self) -> usize {
        self.parameters.len() + self.floating.len()
    }

    fn evaluate(&self, z: &[f64], order: Order) -> Result<Energy, InferenceError> {
        self.energy(z, order, None)
    }

    fn named_point(&self, z: &[f64]) -> String {
        let (own, noise) = z.split_at(self.parameters.len());
        let sd = |(&g, ln_sd): (&usize, &f64)| {
            format!(", noise '{}' = {:.3e}", self.data.groups()[g].name, ln_sd.exp())
        };
        let noise: String = self.floating.iter().zip(noise).map(sd).collect();
        self.parameters.in_words(&self.parameters.physical(own)) + &noise
    }

    fn scales(&self) -> Vec<f64> {
        let mut scales = self.parameters.scales();
        scales.extend(self.floating.iter().map(|_| 1.0));
        scales
    }
}

/// Chain rule from physical parameters to working coordinates.
fn to_working(prediction: &mut Prediction, maps: &[[f64; 3]], order: Order) {
    let p = maps.len();
    let triangle = p * (p + 1) / 2;
    if order == Order::Value || maps.iter().all(|m| m[1] == 1.0 && m[2] == 0.0) {
        return;
    }
    for row in 0..prediction.values.len() {
        if order == Order::Second {
            let curvature = &mut prediction.curvature[row * triangle..(row + 1) * triangle];
            let mut place = 0;
            for i in 0..p {
                for j in 0..=i {
                    curvature[place] *= maps[i][1] * maps[j][1];
                    place += 1;
                }
                curvature[place - 1] += prediction.jacobian[(row, i)] * maps[i][2];
            }
        }
        for i in 0..p {
            prediction.jacobian[(row, i)] *= maps[i][1];
        }
    }
}
