//! Data foreseen from all others.

use super::{Block, Floating, Linearised};
use crate::InferenceError;
use rijke_numerics::{Cholesky, Matrix, dot};
use std::f64::consts::PI;

/// Data against the prediction from all others.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftOut {
    /// ln of their density, nats.
    pub ln_density: f64,
    /// Measured minus predicted.
    pub residuals: Vec<f64>,
    /// Standard deviation of each.
    pub sds: Vec<f64>,
    /// How far the parameters move without them, in posterior standard deviations.
    pub shift: f64,
}

/// Steps to the root of a convex function.
const NEWTON: usize = 8;

impl Linearised {
    /// ln of the density of each datum given all others and the parameters, for parameters that lie `moved`
    /// from the fit in working coordinates and a prediction that is linear in them; noise as fitted. With Q =
    /// C^-1 and r the residual there, datum i has the precision `Q_ii` and the residual (Q r)_i / `Q_ii`
    /// (Buerkner, Gabry & Vehtari, Comput. Stat. 36 (2021) 1243).
    ///
    /// # Panics
    /// If `moved` has not one number for each parameter.
    #[must_use]
    pub fn ln_densities(&self, moved: &[f64]) -> Vec<f64> {
        let p = self.root.rows();
        assert_eq!(moved.len(), p, "one number for each parameter");
        // S xi = moved, S being upper triangular.
        let mut xi = moved.to_vec();
        for i in (0..p).rev() {
            let known: f64 = (i + 1..p).map(|j| self.root[(j, i)] * xi[j]).sum();
            xi[i] = (xi[i] - known) / self.root[(i, i)];
        }
        let mut found = Vec::with_capacity(self.pulls.len());
        for block in &self.blocks {
            for i in 0..block.covariance.rows() {
                let place = block.first + i;
                let (pull, precision) =
                    (self.pulls[place] - dot(self.learnt.row(place), &xi), block.inverse[(i, i)]);
                found.push(0.5 * ((precision / (2.0 * PI)).ln() - pull * pull / precision));
            }
        }
        found
    }

    /// The variance of a noise, in that of the fit, where it is chosen from data of which it would explain
    /// `count` and explains `explained`: the root of the derivative of J, with the prior's pull as it is at
    /// the fit and the floor left out.
    fn chosen_again(noise: &Floating, explained: f64, count: f64) -> f64 {
        let mut shift = 0.0;
        for _ in 0..NEWTON {
            let now = explained * f64::exp(-2.0 * shift);
            let slope = now - count - (noise.explained - noise.count) - shift * noise.precision;
            shift += slope / (2.0 * now.max(0.5 * count) + noise.precision);
        }
        f64::exp(2.0 * shift)
    }

    /// The data at `places` given all others: the conditional density of a Gaussian. With P the inverse
    /// covariance of all and a = P r, the covariance is `P_SS`^-1 and the residual `P_SS`^-1 `a_S`. Noise
    /// that floats is chosen again from the others, to first order in its change.
    ///
    /// # Errors
    /// [`InferenceError::Dense`] if these data alone decide a parameter.
    pub fn left_out(&self, places: &[usize]) -> Result<LeftOut, InferenceError> {
        let n = places.len();
        let block = |i: usize| self.blocks.partition_point(|b| b.first <= i) - 1;
        let within = |a: usize, b: usize, of: &dyn Fn(&Block) -> f64| {
            if block(a) == block(b) { of(&self.blocks[block(a)]) } else { 0.0 }
        };
        let precision = Matrix::from_fn(n, n, |i, j| {
            let (a, b) = (places[i], places[j]);
            let own = within(a, b, &|own| own.inverse[(a - own.first, b - own.first)]);
            own - dot(self.learnt.row(a), self.learnt.row(b))
        });
        let factor = Cholesky::new(&precision)?;
        let residuals = factor.solve(&places.iter().map(|&i| self.pulls[i]).collect::<Vec<f64>>());
        let covariance = factor.inverse();
        let mut moved = vec![0.0; self.residuals.len()];
        places.iter().zip(&residuals).for_each(|(&i, r)| moved[i] = *r);
        let shift = self.told_by(&moved).iter().map(|t| t * t).sum::<f64>().sqrt();
        let others: Vec<f64> = self.pulls.iter().zip(self.pulled(&moved)).map(|(a, b)| a - b).collect();
        // What a datum given all others takes from each of them: the columns of P for these data times their
        // covariance.
        let weights: Vec<Vec<f64>> = (0..n)
            .map(|j| {
                let mut column = vec![0.0; self.residuals.len()];
                places.iter().enumerate().for_each(|(i, &place)| column[place] = covariance[(i, j)]);
                self.pulled(&column)
            })
            .collect();
        let (mut total, mut left) = (covariance, residuals);
        for noise in &self.floating {
            let explains = |&i: &usize| -> f64 {
                let (k, own) = (block(i), &self.blocks[block(i)]);
                let parts = noise.parts.iter().filter(|(block, _)| *block == k);
                parts.map(|(_, part)| dot(part.row(i - own.first), own.inverse.row(i - own.first))).sum()
            };
            let count = noise.count - places.iter().map(explains).sum::<f64>();
            let again = Self::chosen_again(noise, self.within(noise, &others, &others), count);
            let change = again.max(noise.floor) - 1.0;
            let moved: Vec<Vec<f64>> = weights.iter().map(|w| self.through(noise, w)).collect();
            for i in 0..n {
                left[i] -= change * dot(&moved[i], &others);
                for j in 0..n {
                    total[(i, j)] += change * dot(&moved[i], &weights[j]);
                }
            }
        }
        let factor = Cholesky::new(&total)?;
        let square: f64 = factor.whiten(&left).iter().map(|w| w * w).sum();
        Ok(LeftOut {
            ln_density: -0.5 * (factor.ln_det() + square + n as f64 * (2.0 * PI).ln()),
            sds: (0..n).map(|i| total[(i, i)].sqrt()).collect(),
            residuals: left,
            shift,
        })
    }
}
