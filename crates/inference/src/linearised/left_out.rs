//! Data foreseen from all others.

use super::{Block, Floating, Linearised};
use crate::InferenceError;
use rijke_numerics::{Cholesky, Matrix, dot};
use std::collections::{BTreeMap, BTreeSet};
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

/// What data given all others take from each of them: W, the columns of P for these data times their
/// covariance. In blocks that hold none of them it is -L A, with L the block's rows of what is learnt.
struct Weights {
    /// A: a column for each datum.
    along: Matrix,
    /// The rows of each block that holds some of them.
    own: BTreeMap<usize, Matrix>,
}

impl Weights {
    /// W'S W and W'S v, with S the covariance of a floating noise.
    fn through(&self, linear: &Linearised, noise: &Floating, v: &[f64]) -> (Matrix, Vec<f64>) {
        let (p, n) = (self.along.rows(), self.along.columns());
        let (mut square, mut pull) = (Matrix::zeros(n, n), vec![0.0; n]);
        let (mut learnt, mut told) = (Matrix::zeros(p, p), vec![0.0; p]);
        let add = |to: &mut [f64], row: &[f64], factor: f64| {
            to.iter_mut().zip(row).for_each(|(t, r)| *t += factor * r);
        };
        for part in &noise.parts {
            let range = linear.own(part);
            let pulled = part.covariance.times(&v[range.clone()]);
            if let Some(own) = self.own.get(&part.block) {
                square =
                    square.plus(1.0, &own.transpose().large_product(&part.covariance.large_product(own)));
                pulled.iter().enumerate().for_each(|(r, value)| add(&mut pull, own.row(r), *value));
            } else {
                learnt = learnt.plus(1.0, &part.learnt);
                range.zip(&pulled).for_each(|(i, value)| add(&mut told, linear.learnt.row(i), *value));
            }
        }
        let turned = self.along.transpose();
        add(&mut pull, &turned.times(&told), -1.0);
        (square.plus(1.0, &turned.large_product(&learnt.large_product(&self.along))), pull)
    }
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

    /// The weights of the data at `places`, in these blocks, whose covariance given all others this is.
    fn weights(&self, places: &[usize], covariance: &Matrix, touched: &BTreeSet<usize>) -> Weights {
        let (p, n) = (self.learnt.columns(), places.len());
        let rows = Matrix::from_fn(n, p, |i, j| self.learnt[(places[i], j)]);
        let along = rows.transpose().large_product(covariance);
        let of = |k: usize| {
            let block = &self.blocks[k];
            let m = block.inverse.rows();
            let here = |i: usize| places[i].checked_sub(block.first).filter(|at| *at < m);
            let columns = Matrix::from_fn(m, n, |r, i| here(i).map_or(0.0, |at| block.inverse[(r, at)]));
            let learnt = Matrix::from_fn(m, p, |r, j| self.learnt[(block.first + r, j)]);
            columns.large_product(covariance).plus(-1.0, &learnt.large_product(&along))
        };
        let own = touched.iter().map(|&k| (k, of(k))).collect();
        Weights { along, own }
    }

    /// The data at `places` given all others: the conditional density of a Gaussian. With P the inverse
    /// covariance of all and a = P r, the covariance is `P_SS`^-1 and the residual `P_SS`^-1 `a_S`. Noise
    /// that floats is chosen again from the others, to first order in its change.
    ///
    /// # Errors
    /// [`InferenceError::Dense`] if these data alone decide a parameter.
    ///
    /// # Panics
    /// If there is no datum at one of the `places`.
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
        let touched: BTreeSet<usize> = places.iter().map(|&i| block(i)).collect();
        let weights = self.weights(places, &covariance, &touched);
        let (mut total, mut left) = (covariance, residuals);
        for noise in &self.floating {
            let explains = |&i: &usize| -> f64 {
                let (k, own) = (block(i), &self.blocks[block(i)]);
                let parts = noise.parts.iter().filter(|part| part.block == k);
                let row = i - own.first;
                parts.map(|part| dot(part.covariance.row(row), own.inverse.row(row))).sum()
            };
            let count = noise.count - places.iter().map(explains).sum::<f64>();
            let again = Self::chosen_again(noise, self.within(noise, &others, &others), count);
            let change = again.max(noise.floor) - 1.0;
            let (square, pull) = weights.through(self, noise, &others);
            total = total.plus(change, &square);
            left.iter_mut().zip(&pull).for_each(|(l, p)| *l -= change * p);
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
