//! Likelihood of a block whose covariance is a diagonal and columns, by the matrix inversion lemma.

use super::block::{Block, Likelihood, add_symmetric};
use crate::problem::Structured;
use rijke_numerics::{Cholesky, DenseError, Matrix, Order, dot};
use std::f64::consts::PI;

/// C = D + U K U' with its factor M = I + K^1/2 U'D^-1 U K^1/2, which is never singular.
pub(crate) struct Woodbury {
    diagonal: Vec<f64>,
    /// 1/D.
    weights: Vec<f64>,
    /// K^1/2.
    roots: Vec<f64>,
    /// K^1/2 U'D^-1 U K^1/2.
    gram: Matrix,
    factor: Cholesky,
    ln_det: f64,
}

/// A group that floats in this block: dC = diag(d) + U diag(K a) U' for a change of one in ln of its standard
/// deviation.
struct Acting {
    coordinate: usize,
    d: Option<Vec<f64>>,
    a: Option<Vec<f64>>,
    /// K^1/2 U' diag(d/D^2) U K^1/2.
    t: Option<Matrix>,
    /// dC alpha.
    pull: Vec<f64>,
}

impl Woodbury {
    pub(crate) fn new(structured: &Structured, sds: &[f64]) -> Result<Self, DenseError> {
        let diagonal = structured.diagonal(sds);
        let size = diagonal.len();
        if let Some(pivot) = diagonal.iter().position(|d| !(*d > 0.0 && d.is_finite())) {
            return Err(DenseError::NotPositiveDefinite { size, pivot });
        }
        let weights: Vec<f64> = diagonal.iter().map(|d| 1.0 / d).collect();
        let roots: Vec<f64> = structured.ln_variances(sds).iter().map(|v| (0.5 * v).exp()).collect();
        let gram = scaled(&structured.columns.weighted_gram(&weights), &roots);
        let factor = Cholesky::new(&gram.plus(1.0, &Matrix::identity(roots.len())))?;
        let ln_det = diagonal.iter().map(|d| d.ln()).sum::<f64>() + factor.ln_det();
        Ok(Self { diagonal, weights, roots, gram, factor, ln_det })
    }

    /// Coefficients c = M^-1 K^1/2 U'D^-1 X of the columns of X, and what is left: X - U K^1/2 c.
    /// Then X'C^-1 X = left' D^-1 left + c'c, a sum without cancellation, and C^-1 X = D^-1 left.
    fn split(&self, columns: &Matrix, x: &Matrix) -> (Matrix, Matrix) {
        let (q, p) = (self.roots.len(), x.columns());
        if q == 0 || p == 0 {
            return (Matrix::zeros(q, p), x.clone());
        }
        let along = columns.weighted_product(&self.weights, x);
        let solved: Vec<Vec<f64>> = (0..p)
            .map(|j| self.factor.solve(&(0..q).map(|k| self.roots[k] * along[(k, j)]).collect::<Vec<_>>()))
            .collect();
        let c = Matrix::from_fn(q, p, |k, j| solved[j][k]);
        let amplitudes = Matrix::from_fn(q, p, |k, j| self.roots[k] * c[(k, j)]);
        let left = x.plus(-1.0, &columns.large_product(&amplitudes));
        (c, left)
    }
}

impl Likelihood<'_> {
    /// As [`Likelihood::block`], for C = D + U K U'.
    pub(crate) fn structured_block(&self, structured: &Structured, known: &Woodbury, order: Order) -> Block {
        let (n, p) = (self.observation.values.len(), self.parameters);
        let residual =
            Matrix::from_fn(n, 1, |i, _| self.prediction.values[self.first + i] - self.observation.values[i]);
        let (c, left) = known.split(&structured.columns, &residual);
        let alpha: Vec<f64> = left.as_slice().iter().zip(&known.weights).map(|(l, w)| l * w).collect();
        let square = dot(left.as_slice(), &alpha) + dot(c.as_slice(), c.as_slice());
        let ln_likelihood = -0.5 * (square + known.ln_det + n as f64 * (2.0 * PI).ln());
        let mut block = Block { ln_likelihood, ..Block::default() };
        if order == Order::Value {
            return block;
        }
        let size = p + self.floating.len();
        block.gradient = vec![0.0; size];
        block.gauss_newton = Matrix::zeros(size, size);
        let start = self.first * p;
        let rows = &self.prediction.jacobian.as_slice()[start..start + n * p];
        for (row, a) in rows.chunks_exact(p.max(1)).zip(&alpha) {
            for (g, f) in block.gradient.iter_mut().zip(row) {
                *g += a * f;
            }
        }
        let mut turned = Matrix::zeros(n, 0);
        if (order == Order::Second || self.floating.is_empty()) && p > 0 {
            let jacobian = Matrix::from_fn(n, p, |i, j| rows[i * p + j]);
            let (c, left) = known.split(&structured.columns, &jacobian);
            let sum = left.weighted_gram(&known.weights).plus(1.0, &c.transpose().product(&c));
            for i in 0..p {
                for j in 0..p {
                    block.gauss_newton[(i, j)] = sum[(i, j)];
                }
            }
            turned = Matrix::from_fn(n, p, |i, j| known.weights[i] * left[(i, j)]);
        }
        if order == Order::Second && p > 0 && !self.prediction.curvature.is_empty() {
            block.curvature = self.bend(&alpha);
        }
        if !self.floating.is_empty() {
            self.add_structured_noise(&mut block, structured, known, &alpha, &turned, order);
        }
        block
    }

    /// Derivatives with respect to ln of floating sizes. With a = C^-1 r, C_g = dC/du_g, N = M^-1 and Q = I -
    /// N = K^1/2 U'C^-1 U K^1/2: dJ/du_g = (tr C^-1 C_g - a'C_g a)/2, d2J/du_g du_h = (tr C^-1 C_gh - tr C^-1
    /// C_g C^-1 C_h - a'C_gh a)/2 + a'C_g C^-1 C_h a, d2J/dz du_g = -F'C^-1 C_g a, and the traces from N, Q
    /// and T_g = K^1/2 U' diag(d_g/D^2) U K^1/2 alone.
    fn add_structured_noise(
        &self,
        block: &mut Block,
        structured: &Structured,
        known: &Woodbury,
        alpha: &[f64],
        turned: &Matrix,
        order: Order,
    ) {
        let (p, q) = (self.parameters, known.roots.len());
        let inverse = known.factor.inverse();
        let along = column_products(&structured.columns, alpha);
        // K^1/2 U'C^-1 r, and the diagonal of Q.
        let pulled: Vec<f64> = along.iter().zip(&known.roots).map(|(u, r)| u * r).collect();
        let share: Vec<f64> = (0..q).map(|j| 1.0 - inverse[(j, j)]).collect();
        let mut grams = Grams {
            columns: &structured.columns,
            roots: &known.roots,
            found: vec![(known.weights.clone(), known.gram.clone())],
        };
        let acting: Vec<Acting> = self
            .floating
            .iter()
            .enumerate()
            .filter_map(|(c, &g)| self.acting(structured, known, (g, p + c), (alpha, &pulled), &mut grams))
            .collect();
        for (k, x) in acting.iter().enumerate() {
            let diagonal = x.d.as_ref().map_or(0.0, |d| dot(d, &known.weights))
                - x.t.as_ref().map_or(0.0, |t| dot(t.as_slice(), inverse.as_slice()));
            let columns = x.a.as_ref().map_or(0.0, |a| dot(a, &share));
            block.gradient[x.coordinate] += 0.5 * (diagonal + columns - dot(&x.pull, alpha));
            if order < Order::Second {
                continue;
            }
            for i in 0..p {
                let slope: f64 = (0..alpha.len()).map(|r| turned[(r, i)] * x.pull[r]).sum();
                add_symmetric(&mut block.gauss_newton, x.coordinate, i, -slope);
            }
            let pull = Matrix::from_fn(alpha.len(), 1, |i, _| x.pull[i]);
            let (cx, left) = known.split(&structured.columns, &pull);
            for (l, y) in acting[..=k].iter().enumerate() {
                let py = Matrix::from_fn(alpha.len(), 1, |i, _| y.pull[i]);
                let (cy, left_y) = known.split(&structured.columns, &py);
                let inner: f64 =
                    (0..alpha.len()).map(|i| left[(i, 0)] * known.weights[i] * left_y[(i, 0)]).sum();
                let force = inner + dot(cx.as_slice(), cy.as_slice());
                let mut second = 0.0;
                if l == k && x.d.is_some() {
                    // C_gg = 2 diag(d) for a variance.
                    let own =
                        x.d.as_ref()
                            .map_or(0.0, |d| (0..alpha.len()).map(|i| d[i] * alpha[i] * alpha[i]).sum());
                    second += 2.0 * (diagonal - own);
                }
                if let (Some(a), Some(b)) = (&x.a, &y.a) {
                    second += (0..q).map(|j| a[j] * b[j] * (share[j] - pulled[j] * pulled[j])).sum::<f64>();
                }
                let product = trace_of_product(x, y, known, &inverse, &mut grams);
                let bend = 0.5 * (second - product) + force;
                block.gauss_newton[(x.coordinate, y.coordinate)] += bend;
                if l < k {
                    block.gauss_newton[(y.coordinate, x.coordinate)] += bend;
                }
            }
        }
    }

    /// What a floating group does in this block; none if it does not act here.
    fn acting(
        &self,
        structured: &Structured,
        known: &Woodbury,
        (group, coordinate): (usize, usize),
        (alpha, pulled): (&[f64], &[f64]),
        grams: &mut Grams,
    ) -> Option<Acting> {
        let n = alpha.len();
        let variance = self.sds[group] * self.sds[group];
        let mut d: Option<Vec<f64>> = None;
        for (_, s) in structured.noise.iter().filter(|(g, _)| *g == group) {
            let to = d.get_or_insert_with(|| vec![0.0; n]);
            for (to, s) in to.iter_mut().zip(s) {
                *to += 2.0 * variance * s;
            }
        }
        let a = structured.slopes(group);
        if d.is_none() && a.is_none() {
            return None;
        }
        let mut pull = vec![0.0; n];
        if let Some(a) = &a {
            let amplitudes: Vec<f64> = (0..a.len()).map(|j| known.roots[j] * a[j] * pulled[j]).collect();
            pull = structured.columns.times(&amplitudes);
        }
        let mut t = None;
        if let Some(d) = &d {
            for i in 0..n {
                pull[i] += d[i] * alpha[i];
            }
            t = Some(grams.of(&(0..n).map(|i| d[i] * known.weights[i].powi(2)).collect::<Vec<_>>()));
        }
        Some(Acting { coordinate, d, a, t, pull })
    }
}

/// tr C^-1 C_g C^-1 C_h.
fn trace_of_product(x: &Acting, y: &Acting, known: &Woodbury, inverse: &Matrix, grams: &mut Grams) -> f64 {
    let q = known.roots.len();
    let mut sum = 0.0;
    if let (Some(d), Some(e), Some(t), Some(u)) = (&x.d, &y.d, &x.t, &y.t) {
        let weights: Vec<f64> = (0..d.len()).map(|i| d[i] * e[i] * known.weights[i].powi(3)).collect();
        sum += (0..d.len()).map(|i| weights[i] * known.diagonal[i]).sum::<f64>();
        sum -= 2.0 * dot(grams.of(&weights).as_slice(), inverse.as_slice());
        let (nt, nu) = (inverse.large_product(t), inverse.large_product(u));
        sum += dot(nt.as_slice(), nu.transpose().as_slice());
    }
    for (first, second) in [(x, y), (y, x)] {
        if let (Some(t), Some(a)) = (&first.t, &second.a) {
            let turned = inverse.large_product(t);
            sum += (0..q).map(|j| a[j] * dot(turned.row(j), inverse.row(j))).sum::<f64>();
        }
    }
    if let (Some(a), Some(b)) = (&x.a, &y.a) {
        for j in 0..q {
            let row: f64 =
                (0..q).map(|k| (f64::from(u8::from(j == k)) - inverse[(j, k)]).powi(2) * b[k]).sum();
            sum += a[j] * row;
        }
    }
    sum
}

/// The products K^1/2 U' diag(w) U K^1/2 for several weights; those that are multiples of others are made
/// once.
struct Grams<'a> {
    columns: &'a Matrix,
    roots: &'a [f64],
    found: Vec<(Vec<f64>, Matrix)>,
}

impl Grams<'_> {
    fn of(&mut self, weights: &[f64]) -> Matrix {
        for (known, gram) in &self.found {
            let ratio = dot(weights, known) / dot(known, known).max(f64::MIN_POSITIVE);
            if weights.iter().zip(known).all(|(w, k)| (w - ratio * k).abs() <= 1e-13 * w.abs()) {
                return Matrix::zeros(gram.rows(), gram.columns()).plus(ratio, gram);
            }
        }
        let gram = scaled(&self.columns.weighted_gram(weights), self.roots);
        self.found.push((weights.to_vec(), gram.clone()));
        gram
    }
}

fn scaled(gram: &Matrix, roots: &[f64]) -> Matrix {
    Matrix::from_fn(roots.len(), roots.len(), |i, j| roots[i] * gram[(i, j)] * roots[j])
}

/// U'x.
fn column_products(columns: &Matrix, x: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; columns.columns()];
    for (i, x) in x.iter().enumerate() {
        for (o, u) in out.iter_mut().zip(columns.row(i)) {
            *o += x * u;
        }
    }
    out
}
