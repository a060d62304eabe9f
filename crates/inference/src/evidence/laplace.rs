//! Laplace's method: the posterior as a Gaussian at its maximum, and the evidence that follows.

use crate::density::{Method, Objective};
use crate::error::InferenceError;
use crate::fit::{Conditional, Fit, Posterior};
use crate::problem::Parameter;
use rijke_numerics::{Cholesky, Matrix, Order, symmetric_eigen};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Evidence for a model in the sense of section 5.3 of the paper: ln ML = ln BFL + ln OF, in nats.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// ln P(D | a) at the maximum of the posterior: how well the best parameters fit.
    pub ln_best_fit: f64,
    /// ln of P(a) det(A / 2 pi)^-1/2, as in equation (9): the fraction of the prior volume that survives the
    /// data; negative as a rule.
    pub ln_occam: f64,
    /// ln P(D), equation (9): the sum of both.
    pub ln_marginal: f64,
    /// The number by which tables divide: the number of observations, that is of operating points.
    pub datapoints: usize,
}

/// The Gaussian approximation of a posterior at its maximum.
#[derive(Clone, Debug)]
pub struct Laplace {
    /// Working coordinates of the maximum: parameters, then ln sd of inferred noise. Floated noise is held at
    /// its best.
    pub mean: Vec<f64>,
    /// A = d2J/dz2 (equation 6, with J in nats): the sum of the next three.
    pub hessian: Matrix,
    /// The part of A made of first derivatives of the prediction.
    pub gauss_newton: Matrix,
    /// The part of A made of second derivatives of the prediction, zero if the model has none.
    pub curvature: Matrix,
    /// The part of A that the prior brings.
    pub prior: Matrix,
    /// Inverse of A: the covariance in working coordinates.
    pub covariance: Matrix,
    /// True if the model offers no second derivatives, so that A is the Gauss-Newton matrix.
    pub gauss_newton_only: bool,
    /// Evidence.
    pub evidence: Evidence,
    /// Physical parameters at the maximum.
    pub parameters: Vec<f64>,
    /// Covariance of the physical parameters, to first order in the transforms.
    pub physical_covariance: Matrix,
    /// Standard deviation of each of them.
    sds: Vec<f64>,
    /// Half of g' A^-1 g, nats: how far the fit was from the maximum.
    pub decrement: f64,
    /// How far the BFGS matrix of the search is from A: the largest eigenvalue in modulus of A^-1/2 (B - A)
    /// A^-1/2. The paper calls B excellent. Nothing if the search used exact Hessians.
    pub bfgs_distance: Option<f64>,
}

impl Laplace {
    /// Posterior standard deviation of each physical parameter, as [`Parameter::sd_about`] has it, with a
    /// noise that floats taken for known. Where few data choose that noise it is too small: of the mean of
    /// three data two of them hold the truth in 7 of 10 cases. [`crate::Assessment::sd`] and
    /// [`crate::Linearised::few`] widen it.
    #[must_use]
    pub fn sd(&self) -> Vec<f64> {
        self.sds.clone()
    }

    /// Size of the second-derivative part of A against its first-derivative part: the largest eigenvalue in
    /// modulus of G^-1/2 K G^-1/2, where K is the former and G the rest of A. The paper calls it an order of
    /// magnitude smaller.
    #[must_use]
    pub fn curvature_ratio(&self) -> f64 {
        relative_size(&self.gauss_newton.plus(1.0, &self.prior), &self.curvature)
    }
}

impl Posterior<'_> {
    /// The Gaussian approximation at `fit`, which must be one of this posterior, and the evidence.
    ///
    /// Cost: one call of the model with second derivatives.
    ///
    /// # Errors
    /// [`InferenceError::NoLaplace`] if A is not positive definite there, [`InferenceError::Improper`] if a
    /// prior is [`crate::Prior::Flat`]; use [`Posterior::laplace_of_likelihood`] for that case.
    pub fn laplace(&self, fit: &Fit) -> Result<Laplace, InferenceError> {
        if let Some(parameter) = self.parameters().improper() {
            return Err(InferenceError::Improper { parameter: parameter.name.clone() });
        }
        self.laplace_of_likelihood(fit)
    }

    /// As [`Posterior::laplace`], but for improper priors too: the covariance is meaningful, the evidence is
    /// not.
    ///
    /// # Errors
    /// [`InferenceError::NoLaplace`].
    pub fn laplace_of_likelihood(&self, fit: &Fit) -> Result<Laplace, InferenceError> {
        let parts = self.parts(&fit.working, Order::Second)?;
        let (p, keep) = (self.parameters().len(), self.integrated());
        let (gauss_newton, curvature, prior) =
            (parts.gauss_newton.select(&keep), parts.curvature.select(&keep), parts.prior.select(&keep));
        // Equation (6): A is the Hessian of J.
        let hessian = gauss_newton.plus(1.0, &curvature).plus(1.0, &prior);
        let factor = Cholesky::new(&hessian).map_err(|_| self.no_laplace(&hessian, &keep))?;
        // Equation (9), its second factor.
        let ln_occam = parts.ln_prior - 0.5 * factor.ln_det() + 0.5 * keep.len() as f64 * (2.0 * PI).ln();
        let evidence = Evidence {
            ln_best_fit: parts.ln_likelihood,
            ln_occam,
            ln_marginal: parts.ln_likelihood + ln_occam,
            datapoints: self.data().observations().len(),
        };
        let covariance = factor.inverse();
        let slopes: Vec<f64> =
            self.parameters().list().iter().zip(&fit.working).map(|(q, &z)| q.physical(z)[1]).collect();
        let sd = |(i, q): (usize, &Parameter)| {
            q.sd_about(fit.parameters[i], slopes[i].abs() * covariance[(i, i)].sqrt())
        };
        let gradient: Vec<f64> = keep.iter().map(|&i| parts.gradient[i]).collect();
        let bfgs_distance = (fit.method == Method::Bfgs)
            .then(|| relative_size(&hessian, &fit.search_hessian.select(&keep).plus(-1.0, &hessian)));
        Ok(Laplace {
            bfgs_distance,
            mean: keep.iter().map(|&i| fit.working[i]).collect(),
            decrement: 0.5 * covariance.quadratic(&gradient),
            physical_covariance: Matrix::from_fn(p, p, |i, j| slopes[i] * covariance[(i, j)] * slopes[j]),
            sds: self.parameters().list().iter().enumerate().map(sd).collect(),
            parameters: fit.parameters.clone(),
            gauss_newton_only: self.forward().highest_order() < Order::Second,
            hessian,
            gauss_newton,
            curvature,
            prior,
            covariance,
            evidence,
        })
    }

    /// The density whose integral is the evidence: the posterior with floated noise held at its value in
    /// `fit`.
    pub(crate) fn target(&self, fit: &Fit) -> Conditional<'_> {
        Conditional::new(self, fit.working.clone(), self.integrated())
    }

    fn no_laplace(&self, hessian: &Matrix, keep: &[usize]) -> InferenceError {
        let mut scales = self.scales();
        scales.iter_mut().filter(|s| !s.is_finite()).for_each(|s| *s = 1.0);
        let scaled = Matrix::from_fn(keep.len(), keep.len(), |i, j| {
            hessian[(i, j)] * scales[keep[i]] * scales[keep[j]]
        });
        match symmetric_eigen(&scaled) {
            Ok((values, vectors)) => {
                let column: Vec<f64> = (0..keep.len()).map(|i| vectors[(i, 0)]).collect();
                InferenceError::NoLaplace { lowest: values[0], direction: self.in_words(&column, keep) }
            }
            Err(error) => error.into(),
        }
    }

    /// A direction in working coordinates scaled by the prior, as "+0.9 alpha -0.4 beta", largest first.
    pub(crate) fn in_words(&self, direction: &[f64], keep: &[usize]) -> String {
        let mut order: Vec<usize> = (0..direction.len()).collect();
        order.sort_by(|&i, &j| direction[j].abs().total_cmp(&direction[i].abs()));
        let name = |i: usize| match self.parameters().list().get(keep[i]) {
            Some(parameter) => parameter.name.clone(),
            None => {
                let group = self.floating()[keep[i] - self.parameters().len()];
                format!("ln sd of {}", self.data().groups()[group].name)
            }
        };
        let words: Vec<String> = order
            .iter()
            .filter(|&&i| direction[i].abs() > 0.1)
            .map(|&i| format!("{:+.2} {}", direction[i], name(i)))
            .collect();
        words.join(" ")
    }
}

/// Largest modulus of the eigenvalues of `base`^-1/2 `part` `base`^-1/2; infinite if `base` is not positive
/// definite.
fn relative_size(base: &Matrix, part: &Matrix) -> f64 {
    let Ok(factor) = Cholesky::new(base) else { return f64::INFINITY };
    let n = base.rows();
    let half: Vec<Vec<f64>> =
        (0..n).map(|j| factor.whiten(&(0..n).map(|i| part[(i, j)]).collect::<Vec<_>>())).collect();
    // half[j] is column j of L^-1 K; whiten its rows to get L^-1 K L^-T.
    let whole: Vec<Vec<f64>> =
        (0..n).map(|i| factor.whiten(&(0..n).map(|j| half[j][i]).collect::<Vec<_>>())).collect();
    let symmetric = Matrix::from_fn(n, n, |i, j| 0.5 * (whole[i][j] + whole[j][i]));
    symmetric_eigen(&symmetric)
        .map_or(f64::INFINITY, |(values, _)| values.iter().fold(0.0, |largest, v| largest.max(v.abs())))
}
