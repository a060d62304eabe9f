//! The cost J of a model with data: minus ln P(D|a) P(a), with exact derivatives.

use crate::{Data, Energy, Forward, InferenceError, NoiseMode, Objective, Parameters, Prediction};
use rijke_numerics::{Cholesky, Matrix, Order};
use std::f64::consts::PI;

/// A model, its data and its prior: the unnormalised posterior density.
///
/// Coordinates: the working coordinates of the parameters, then ln sd of every noise that floats or is inferred.
/// Cost of [`Objective::evaluate`]: one call of the model and, for each block of n data, O(n^3) with floating noise
/// and O(n^2 p) without.
pub struct Posterior<'a> {
    forward: &'a dyn Forward,
    data: &'a Data,
    parameters: &'a Parameters,
    /// For each coordinate after the parameters, the group of noise.
    floating: Vec<usize>,
    /// Factors of the covariance, if nothing floats.
    fixed: Option<Vec<Cholesky>>,
}

/// The cost in its parts, at one point.
#[derive(Clone, Debug)]
pub(crate) struct Parts {
    pub(crate) ln_likelihood: f64,
    pub(crate) ln_prior: f64,
    pub(crate) gradient: Vec<f64>,
    /// Second derivatives of -ln likelihood: products of first derivatives of the prediction (and of the noise).
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
        let mut posterior = Self { forward, data, parameters, floating, fixed: None };
        if posterior.floating.is_empty() {
            let sds = posterior.noise_sd(&posterior.parameters.centre());
            posterior.fixed = Some(
                (0..data.observations().len())
                    .map(|k| posterior.factor(k, &sds))
                    .collect::<Result<_, _>>()?,
            );
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

    /// The standard deviation of every group of noise at the point `z`.
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

    /// The covariance of block `k` with the standard deviations `sds`.
    #[must_use]
    pub fn covariance(&self, k: usize, sds: &[f64]) -> Matrix {
        let observation = &self.data.observations()[k];
        let n = observation.values.len();
        let floor = observation.floor.clone().unwrap_or_else(|| Matrix::zeros(n, n));
        observation.noise.iter().fold(floor, |sum, (g, s)| sum.plus(sds[*g] * sds[*g], s))
    }

    fn factor(&self, k: usize, sds: &[f64]) -> Result<Cholesky, InferenceError> {
        Cholesky::new(&self.covariance(k, sds)).map_err(|source| InferenceError::SingularCovariance {
            observation: self.data.observations()[k].label.clone(),
            source,
        })
    }

    /// Calls the model and checks the sizes of what it returns.
    ///
    /// # Errors
    /// Those of the model, [`InferenceError::Shape`], and [`InferenceError::NotFinite`] for a prediction that is not finite.
    pub fn predict(&self, values: &[f64], order: Order) -> Result<Prediction, InferenceError> {
        let prediction = self.forward.predict(values, order.min(self.forward.highest_order()))?;
        let (m, p) = (self.data.size(), self.parameters.len());
        let check = |what, found, expected| {
            if found == expected { Ok(()) } else { Err(InferenceError::Shape { what, found, expected }) }
        };
        check("a prediction", prediction.values.len(), m)?;
        if order >= Order::First {
            check("a jacobian", prediction.jacobian.as_slice().len(), m * p)?;
        }
        if order.min(self.forward.highest_order()) == Order::Second {
            check("a curvature", prediction.curvature.len(), m * p * (p + 1) / 2)?;
        }
        match prediction.values.iter().find(|v| !v.is_finite()) {
            Some(&value) => Err(InferenceError::NotFinite { value, at: values.to_vec() }),
            None => Ok(prediction),
        }
    }

    /// J in its parts.
    pub(crate) fn parts(&self, z: &[f64], order: Order) -> Result<Parts, InferenceError> {
        let (p, n) = (self.parameters.len(), self.size());
        let prior = self.parameters.ln_density(&z[..p])?;
        let maps: Vec<[f64; 3]> = self.parameters.list().iter().zip(z).map(|(q, &z)| q.physical(z)).collect();
        let values: Vec<f64> = maps.iter().map(|m| m[0]).collect();
        let mut prediction = self.predict(&values, order)?;
        to_working(&mut prediction, &maps, order.min(self.forward.highest_order()));
        let sds = self.noise_sd(z);
        let mut parts = Parts {
            ln_likelihood: 0.0,
            ln_prior: prior.value,
            gradient: vec![0.0; n],
            gauss_newton: Matrix::zeros(n, n),
            curvature: Matrix::zeros(n, n),
            prior: Matrix::zeros(n, n),
            prediction,
        };
        for i in 0..p {
            parts.gradient[i] = -prior.gradient[i];
            for j in 0..p {
                parts.prior[(i, j)] = -prior.hessian[(i, j)];
            }
        }
        for (k, &g) in self.floating.iter().enumerate() {
            if let NoiseMode::Inferred { median, ln_sd } = self.data.groups()[g].mode {
                let t = (z[p + k] - median.ln()) / ln_sd;
                parts.ln_prior -= 0.5 * t * t + ln_sd.ln() + 0.5 * (2.0 * PI).ln();
                parts.gradient[p + k] += t / ln_sd;
                parts.prior[(p + k, p + k)] = 1.0 / (ln_sd * ln_sd);
            }
        }
        let mut first = 0;
        for k in 0..self.data.observations().len() {
            let fresh;
            let factor = match &self.fixed {
                Some(factors) => &factors[k],
                None => {
                    fresh = self.factor(k, &sds)?;
                    &fresh
                }
            };
            self.add_block(&mut parts, k, first, factor, &sds, order);
            first += self.data.observations()[k].values.len();
        }
        Ok(parts)
    }

    /// Adds -ln of the likelihood of block `k`, whose data start at `first`, and its derivatives.
    ///
    /// With r the residual, C the covariance, a = C^-1 r and t = sd^2:
    /// J = r'a/2 + ln det(2 pi C)/2, dJ/dz = f_z' a, dJ/dt = (-a'Sa + tr C^-1 S)/2,
    /// d2J/dz2 = f_z' C^-1 f_z + a f_zz, d2J/dz dt = -f_z' C^-1 S a, d2J/dt du = a'S C^-1 U a - tr(C^-1 S C^-1 U)/2.
    fn add_block(
        &self,
        parts: &mut Parts,
        k: usize,
        first: usize,
        factor: &Cholesky,
        sds: &[f64],
        order: Order,
    ) {
        let (observation, p) = (&self.data.observations()[k], self.parameters.len());
        let n = observation.values.len();
        let residual: Vec<f64> =
            (0..n).map(|i| parts.prediction.values[first + i] - observation.values[i]).collect();
        let white = factor.whiten(&residual);
        parts.ln_likelihood -=
            0.5 * (white.iter().map(|w| w * w).sum::<f64>() + factor.ln_det() + n as f64 * (2.0 * PI).ln());
        if order == Order::Value {
            return;
        }
        let alpha = factor.solve(&residual);
        let jacobian = &parts.prediction.jacobian;
        let columns: Vec<Vec<f64>> =
            (0..p).map(|i| (0..n).map(|r| jacobian[(first + r, i)]).collect()).collect();
        let whitened: Vec<Vec<f64>> = columns.iter().map(|c| factor.whiten(c)).collect();
        for i in 0..p {
            parts.gradient[i] += dot(&columns[i], &alpha);
            for j in 0..=i {
                let product = dot(&whitened[i], &whitened[j]);
                add_symmetric(&mut parts.gauss_newton, i, j, product);
            }
        }
        let triangle = p * (p + 1) / 2;
        if order == Order::Second && !parts.prediction.curvature.is_empty() {
            for r in 0..n {
                let row = &parts.prediction.curvature[(first + r) * triangle..(first + r + 1) * triangle];
                let mut place = 0;
                for i in 0..p {
                    for j in 0..=i {
                        add_symmetric(&mut parts.curvature, i, j, alpha[r] * row[place]);
                        place += 1;
                    }
                }
            }
        }
        if self.floating.is_empty() {
            return;
        }
        let inverse = factor.inverse();
        // For each floating noise that acts here: its coordinate, t, S a, and C^-1 S.
        let acting: Vec<(usize, f64, Vec<f64>, Matrix)> = self
            .floating
            .iter()
            .enumerate()
            .flat_map(|(c, &g)| {
                observation.noise.iter().filter(move |(h, _)| *h == g).map(move |(_, s)| (c, g, s))
            })
            .map(|(c, g, s)| (p + c, sds[g] * sds[g], s.times(&alpha), inverse.product(s)))
            .collect();
        for (c, t, pull, relative) in &acting {
            let slope = 0.5 * ((0..n).map(|i| relative[(i, i)]).sum::<f64>() - dot(pull, &alpha));
            // d/d ln sd = 2 t d/dt, and once more for the second derivative.
            parts.gradient[*c] += 2.0 * t * slope;
            if order < Order::Second {
                continue;
            }
            parts.gauss_newton[(*c, *c)] += 4.0 * t * slope;
            let pull_white = factor.solve(pull);
            for i in 0..p {
                add_symmetric(&mut parts.gauss_newton, *c, i, -2.0 * t * dot(&columns[i], &pull_white));
            }
            for (d, u, other, other_relative) in &acting {
                let trace: f64 = (0..n)
                    .map(|i| (0..n).map(|j| relative[(i, j)] * other_relative[(j, i)]).sum::<f64>())
                    .sum();
                parts.gauss_newton[(*c, *d)] += 4.0 * t * u * (dot(&pull_white, other) - 0.5 * trace);
            }
        }
    }
}

impl Objective for Posterior<'_> {
    fn size(&self) -> usize {
        self.parameters.len() + self.floating.len()
    }

    fn evaluate(&self, z: &[f64], order: Order) -> Result<Energy, InferenceError> {
        let parts = self.parts(z, order)?;
        let value = -(parts.ln_likelihood + parts.ln_prior);
        if !value.is_finite() || parts.gradient.iter().any(|g| !g.is_finite()) {
            return Err(InferenceError::NotFinite { value, at: z.to_vec() });
        }
        let mut energy = Energy { value, ..Energy::default() };
        if order >= Order::First {
            energy.gradient = parts.gradient;
        }
        if order == Order::Second {
            let gauss_newton = parts.gauss_newton.plus(1.0, &parts.prior);
            energy.hessian = gauss_newton.plus(1.0, &parts.curvature);
            energy.gauss_newton = Some(gauss_newton);
        }
        Ok(energy)
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

fn add_symmetric(matrix: &mut Matrix, i: usize, j: usize, value: f64) {
    matrix[(i, j)] += value;
    if i != j {
        matrix[(j, i)] += value;
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
