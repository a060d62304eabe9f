//! The shape of the posterior around its maximum: the model to second order, and draws from what follows.
//!
//! Two thousand clicks fix some combinations of unknowns to 1/2000 of their prior width and leave others
//! free. The ridge between is curved by many times its thickness, and a Gaussian (Laplace's method) is then
//! too narrow. Here the readings are taken to second order in coordinates in which they are most nearly
//! linear ([`Axis`]), uniform priors are kept exactly by their scores, and draws come from
//! randomise-then-optimise (Bardsley, Solonen, Haario & Laine 2014, SIAM J. Sci. Comput. 36, A1895): a
//! standard normal vector in the tangent space is carried to the scores that the model gives there, and
//! weighted by the ratio of posterior and proposal. Constant errors of sensors act linearly and are
//! integrated out.

use super::axis::Axis;
use crate::error::FlowError;
use crate::infer::assimilate::estimate::Draws;
use rand::RngExt;
use rand_distr::StandardNormal;
use rijke_numerics::{Cholesky, Matrix, Stream, lu_solve};

/// Draws before weighting: means are then known to 3 % of an sd.
const DRAWS: usize = 2000;

/// Readings to second order around the most probable scores.
pub(crate) struct Shape {
    pub(crate) axes: Vec<Axis>,
    /// Scores at the maximum.
    pub(crate) centre: Vec<f64>,
    /// Products of the whitened terms (residual, minus slopes, minus curvatures), constant errors integrated
    /// out.
    gram: Matrix,
    /// Posterior mean of the constant errors from the terms, and the precision.
    errors: Matrix,
    precision: Cholesky,
}

/// Scores, the monomials there, and their J'G dphi/dz + 1.
type Carried = (Vec<f64>, Vec<f64>, Matrix);

impl Shape {
    /// From the whitened residual without constant errors, its negative slopes `linear` in the axes, negative
    /// second derivatives `second[k][l]` (k <= l), and the whitened readings `errors` of each constant error.
    pub(crate) fn new(
        axes: Vec<Axis>,
        centre: Vec<f64>,
        residual: Vec<f64>,
        linear: Vec<Vec<f64>>,
        second: Vec<Vec<Vec<f64>>>,
        errors: &[Vec<f64>],
    ) -> Result<Self, FlowError> {
        let mut terms = vec![residual];
        terms.extend(linear);
        for (k, row) in second.into_iter().enumerate() {
            for (l, mut column) in row.into_iter().enumerate() {
                if l == 0 {
                    column.iter_mut().for_each(|c| *c *= 0.5);
                }
                debug_assert!(k + l < axes.len());
                terms.push(column);
            }
        }
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let n = errors.len();
        let precision = Cholesky::new(&Matrix::from_fn(n, n, |i, j| {
            dot(&errors[i], &errors[j]) + f64::from(u8::from(i == j))
        }))?;
        let cross = Matrix::from_fn(n, terms.len(), |i, t| dot(&errors[i], &terms[t]));
        let columns: Vec<Vec<f64>> = (0..terms.len())
            .map(|t| precision.solve(&(0..n).map(|i| cross[(i, t)]).collect::<Vec<_>>()))
            .collect();
        let size = terms.len();
        let gram = Matrix::from_fn(size, size, |s, t| {
            let known: f64 = (0..n).map(|i| cross[(i, s)] * columns[t][i]).sum();
            dot(&terms[s], &terms[t]) - known
        });
        let errors = Matrix::from_fn(n, size, |i, t| columns[t][i]);
        Ok(Self { axes, centre, gram, errors, precision })
    }

    /// The monomials 1, d, d_k d_l at `scores`, and their derivatives in the scores (one row per monomial).
    fn monomials(&self, scores: &[f64]) -> (Vec<f64>, Matrix) {
        let m = self.axes.len();
        let (mut d, mut slope) = (vec![0.0; m], vec![0.0; m]);
        for k in 0..m {
            let (y, dy) = self.axes[k].at(scores[k]);
            d[k] = y - self.axes[k].at(self.centre[k]).0;
            slope[k] = dy;
        }
        let size = self.gram.rows();
        let (mut values, mut slopes) = (Vec::with_capacity(size), Matrix::zeros(size, m));
        values.push(1.0);
        for k in 0..m {
            slopes[(values.len(), k)] = slope[k];
            values.push(d[k]);
        }
        for k in 0..m {
            for l in k..m {
                slopes[(values.len(), k)] += d[l] * slope[k];
                slopes[(values.len(), l)] += d[k] * slope[l];
                values.push(d[k] * d[l]);
            }
        }
        (values, slopes)
    }

    /// Half of the squares of residuals and scores, constant errors integrated out.
    fn cost(&self, monomials: &[f64], scores: &[f64]) -> f64 {
        0.5 * (self.gram.quadratic(monomials) + scores.iter().map(|z| z * z).sum::<f64>())
    }

    /// Weighted draws of the posterior.
    pub(crate) fn draws(&self, stream: &mut Stream) -> Result<Draws, FlowError> {
        let m = self.axes.len();
        let (at, slopes) = self.monomials(&self.centre);
        // J'G with J the slopes at the maximum, and the curvature J'GJ + 1 = L L'.
        let pulled = slopes.transpose().product(&self.gram);
        let tangent = Cholesky::new(&pulled.product(&slopes).plus(1.0, &Matrix::identity(m)))?;
        let least = self.cost(&at, &self.centre);
        let (mut scores, mut ln_weights) = (Vec::with_capacity(DRAWS), Vec::with_capacity(DRAWS));
        for _ in 0..DRAWS {
            let white: Vec<f64> = (0..m).map(|_| stream.sample(StandardNormal)).collect();
            let errors: Vec<f64> = (0..self.errors.rows()).map(|_| stream.sample(StandardNormal)).collect();
            let Some((mut drawn, monomials, turn)) = self.carry(&white, &pulled, &tangent)? else { continue };
            // ln|det| of L^-1 turn against L' at the maximum.
            let square = Cholesky::new(&turn.transpose().product(&turn))?;
            let ln_det = 0.5 * square.ln_det() - tangent.ln_det();
            let squares: f64 = white.iter().map(|w| w * w).sum();
            ln_weights.push(least - self.cost(&monomials, &drawn) + 0.5 * squares - ln_det);
            let mean = self.errors.times(&monomials);
            let noise = back_substitute(&self.precision, &errors);
            drawn.extend(mean.iter().zip(noise).map(|(m, n)| m + n));
            scores.push(drawn);
        }
        let largest = ln_weights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let raw: Vec<f64> = ln_weights.iter().map(|w| (w - largest).exp()).collect();
        let sum: f64 = raw.iter().sum();
        if !(sum.is_finite() && sum > 0.0) {
            return Err(FlowError::Inference("no draw of the posterior has a weight".into()));
        }
        Ok(Draws { scores, weights: raw.iter().map(|w| w / sum).collect() })
    }

    /// The scores z with L^-1 (J'G phi(z) + z) = `white`, with the monomials there and J'G dphi/dz + 1; none
    /// if Newton's method does not arrive.
    fn carry(
        &self,
        white: &[f64],
        pulled: &Matrix,
        tangent: &Cholesky,
    ) -> Result<Option<Carried>, FlowError> {
        let m = self.axes.len();
        let goal = tangent.lower().times(white);
        let miss = |monomials: &[f64], z: &[f64]| -> Vec<f64> {
            let now = pulled.times(monomials);
            (0..m).map(|k| goal[k] - now[k] - z[k]).collect()
        };
        // In units of the posterior.
        let size = |miss: &[f64]| tangent.whiten(miss).iter().map(|x| x * x).sum::<f64>();
        let mut z: Vec<f64> =
            self.centre.iter().zip(back_substitute(tangent, white)).map(|(c, s)| c + s).collect();
        let (mut at, mut slopes) = self.monomials(&z);
        let mut off = miss(&at, &z);
        let mut left = size(&off);
        for _ in 0..ROUNDS {
            let turn = pulled.product(&slopes).plus(1.0, &Matrix::identity(m));
            if left < ARRIVED {
                return Ok(Some((z, at, turn)));
            }
            let Ok(step) = lu_solve(&turn, &off) else { return Ok(None) };
            let mut share = 1.0;
            loop {
                let moved: Vec<f64> = z.iter().zip(&step).map(|(z, s)| z + share * s).collect();
                let (there, slopes_there) = self.monomials(&moved);
                let off_there = miss(&there, &moved);
                let left_there = size(&off_there);
                if left_there < left || left_there < ARRIVED {
                    (z, at, slopes, off, left) = (moved, there, slopes_there, off_there, left_there);
                    break;
                }
                share *= 0.5;
                if share < 1e-4 {
                    return Ok(None);
                }
            }
        }
        Ok(None)
    }
}

/// Steps of Newton's method until a draw is given up, and the square of the distance that is near enough, in
/// sd.
const ROUNDS: usize = 50;
const ARRIVED: f64 = 1e-14;

/// L'^-1 w: a draw with covariance (L L')^-1 from white noise w.
fn back_substitute(factor: &Cholesky, white: &[f64]) -> Vec<f64> {
    let l = factor.lower();
    let mut x = white.to_vec();
    for i in (0..x.len()).rev() {
        for k in i + 1..x.len() {
            x[i] -= l[(k, i)] * x[k];
        }
        x[i] /= l[(i, i)];
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use rijke_numerics::Streams;

    /// Mean and sd of two scores by quadrature of exp(-cost).
    fn quadrature(cost: &dyn Fn(f64, f64) -> f64) -> [(f64, f64); 2] {
        let grid = |k: i32| -5.0 + 0.01 * (f64::from(k) + 0.5);
        let (mut sum, mut first, mut square) = (0.0, [0.0; 2], [0.0; 2]);
        for i in 0..1000 {
            for j in 0..1000 {
                let z = [grid(i), grid(j)];
                let w = (-cost(z[0], z[1])).exp();
                sum += w;
                for k in 0..2 {
                    first[k] += w * z[k];
                    square[k] += w * z[k] * z[k];
                }
            }
        }
        [0, 1].map(|k| (first[k] / sum, (square[k] / sum - (first[k] / sum).powi(2)).sqrt()))
    }

    fn compare(shape: &Shape, expected: [(f64, f64); 2]) {
        let draws = shape.draws(&mut Streams::new(1).stream("test")).unwrap();
        assert!(draws.scores.len() == DRAWS && draws.effective() > 300.0, "{}", draws.effective());
        for (k, (mean, sd)) in expected.into_iter().enumerate() {
            let weighted = || draws.scores.iter().zip(&draws.weights);
            let found: f64 = weighted().map(|(z, w)| w * z[k]).sum();
            let variance: f64 = weighted().map(|(z, w)| w * (z[k] - found).powi(2)).sum();
            assert!((found - mean).abs() < 0.08 * sd, "{k}: {found} {mean}");
            assert!((variance.sqrt() / sd - 1.0).abs() < 0.08, "{k}: {} {sd}", variance.sqrt());
        }
    }

    /// A thin parabola: one reading a = z_1 + 0.5 z_2^2 - 0.3 with sd 0.05, next to the priors.
    #[test]
    fn oracle_a_curved_ridge_by_quadrature() {
        let reading = |a: f64, b: f64| (a + 0.5 * b * b - 0.3) / 0.05;
        let cost = |a: f64, b: f64| 0.5 * (reading(a, b).powi(2) + a * a + b * b);
        // The maximum is at b = 0: a/0.05^2 (a - 0.3) + a = 0.
        let at = 0.3 / (1.0 + 0.05_f64.powi(2));
        let second = vec![vec![vec![0.0], vec![0.0]], vec![vec![-1.0 / 0.05]]];
        let (residual, linear) = (vec![-reading(at, 0.0)], vec![vec![-1.0 / 0.05], vec![0.0]]);
        let axes = vec![Axis::Score, Axis::Score];
        let shape = Shape::new(axes, vec![at, 0.0], residual, linear, second, &[]).unwrap();
        compare(&shape, quadrature(&cost));
    }

    /// Uniform priors whose bounds cut the likelihood: a value read below its lowest, and a conductance.
    #[test]
    fn oracle_bounds_by_quadrature() {
        let axes = vec![
            Axis::Value { low: 0.0, high: 0.3 },
            Axis::Conductance { low: 1.0, high: 20.0, series: 5.0 },
        ];
        let reading = |a: f64, b: f64| [(axes[0].at(a).0 - 0.02) / 0.03, (axes[1].at(b).0 - 0.08) / 0.02];
        let cost = |a: f64, b: f64| 0.5 * (reading(a, b).iter().map(|r| r * r).sum::<f64>() + a * a + b * b);
        let at = [-1.0, -0.5];
        let residual = reading(at[0], at[1]).map(|r| -r).to_vec();
        let linear = vec![vec![-1.0 / 0.03, 0.0], vec![0.0, -1.0 / 0.02]];
        let nothing = vec![0.0; 2];
        let second = vec![vec![nothing.clone(), nothing.clone()], vec![nothing]];
        let shape = Shape::new(axes.clone(), at.to_vec(), residual, linear, second, &[]).unwrap();
        compare(&shape, quadrature(&cost));
    }
}
