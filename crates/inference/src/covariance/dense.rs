//! Likelihood of a block whose covariance is a dense matrix.

use super::block::{Block, Likelihood, add_symmetric};
use crate::problem::BlockNoise;
use rijke_numerics::dot;
use rijke_numerics::{Cholesky, Matrix, Order};
use std::f64::consts::PI;

impl Likelihood<'_> {
    /// As [`Likelihood::block`], with r the residual, C the covariance, a = C^-1 r and t = sd^2: J = r'a/2 +
    /// ln det(2 pi C)/2, dJ/dz = f_z' a, dJ/dt = (-a'Sa + tr C^-1 S)/2, d2J/dz2 = f_z' C^-1 f_z + a f_zz,
    /// d2J/dz dt = -f_z' C^-1 S a, d2J/dt du = a'S C^-1 U a - tr(C^-1 S C^-1 U)/2.
    pub(super) fn dense_block(&self, factor: &Cholesky, order: Order) -> Block {
        let (n, p) = (self.observation.values.len(), self.parameters);
        let residual: Vec<f64> =
            (0..n).map(|i| self.prediction.values[self.first + i] - self.observation.values[i]).collect();
        let white = factor.whiten(&residual);
        let square = white.iter().map(|w| w * w).sum::<f64>();
        let ln_likelihood = -0.5 * (square + factor.ln_det() + n as f64 * (2.0 * PI).ln());
        if order == Order::Value {
            return Block { ln_likelihood, ..Block::default() };
        }
        let alpha = factor.solve(&residual);
        let size = p + self.floating.len();
        let mut block = Block {
            ln_likelihood,
            gradient: vec![0.0; size],
            gauss_newton: Matrix::zeros(size, size),
            curvature: Matrix::default(),
        };
        let jacobian = &self.prediction.jacobian;
        // None for a prediction without derivatives, whose noise alone is sought.
        let columns: Vec<Vec<f64>> =
            (0..p).map(|i| (0..n).map(|r| jacobian[(self.first + r, i)]).collect()).collect();
        for i in 0..p {
            block.gradient[i] = dot(&columns[i], &alpha);
        }
        // To first order with floating noise only the gradient is asked for.
        if order == Order::Second || self.floating.is_empty() {
            let whitened: Vec<Vec<f64>> = columns.iter().map(|c| factor.whiten(c)).collect();
            for i in 0..p {
                for j in 0..=i {
                    add_symmetric(&mut block.gauss_newton, i, j, dot(&whitened[i], &whitened[j]));
                }
            }
        }
        if order == Order::Second && p > 0 && !self.prediction.curvature.is_empty() {
            block.curvature = self.bend(&alpha);
        }
        if !self.floating.is_empty() {
            self.add_noise(&mut block, factor, &alpha, &columns, order);
        }
        block
    }

    fn add_noise(
        &self,
        block: &mut Block,
        factor: &Cholesky,
        alpha: &[f64],
        columns: &[Vec<f64>],
        order: Order,
    ) {
        let p = self.parameters;
        let inverse = factor.inverse();
        let mut acting = Vec::new();
        for (c, &g) in self.floating.iter().enumerate() {
            for noise in self.noises.iter().filter(|noise| noise.group == g) {
                acting.push(Acting {
                    noise,
                    coordinate: p + c,
                    variance: self.sds[g] * self.sds[g],
                    pull: noise.times(alpha),
                    trace: noise.trace_with(&inverse),
                    rows: if order == Order::Second { noise.rows_times(&inverse) } else { Matrix::default() },
                });
            }
        }
        for (k, a) in acting.iter().enumerate() {
            let (c, t) = (a.coordinate, a.variance);
            let slope = 0.5 * (a.trace - dot(&a.pull, alpha));
            // d/d ln sd = 2 t d/dt, and once more for the second derivative.
            block.gradient[c] += 2.0 * t * slope;
            if order < Order::Second {
                continue;
            }
            block.gauss_newton[(c, c)] += 4.0 * t * slope;
            let pull_white = factor.solve(&a.pull);
            for (i, column) in columns.iter().enumerate() {
                add_symmetric(&mut block.gauss_newton, c, i, -2.0 * t * dot(column, &pull_white));
            }
            for (l, b) in acting[..=k].iter().enumerate() {
                let trace = a.noise.trace_of_product(&a.rows, b.noise, &b.rows);
                let bend = 4.0 * t * b.variance * (dot(&pull_white, &b.pull) - 0.5 * trace);
                block.gauss_newton[(c, b.coordinate)] += bend;
                if l < k {
                    block.gauss_newton[(b.coordinate, c)] += bend;
                }
            }
        }
    }
}

/// A floating noise on this block: its coordinate, t = sd^2, S a, tr C^-1 S, and, to second order, the rows
/// of S C^-1 that are not zero.
struct Acting<'a> {
    noise: &'a BlockNoise,
    coordinate: usize,
    variance: f64,
    pull: Vec<f64>,
    trace: f64,
    rows: Matrix,
}
