//! What a block with an exact misfit adds, with its derivatives.

use super::KernelFactor;
use crate::covariance::block::{Block, Likelihood, add_symmetric};
use crate::problem::{Kernelled, Structured};
use rijke_numerics::dot;
use rijke_numerics::{Matrix, Order};
use std::f64::consts::PI;

/// A group that floats here: dC = C_g for a change of one in ln of its standard deviation.
struct Acting {
    group: usize,
    coordinate: usize,
    what: What,
    /// C_g C^-1 r.
    pull: Vec<f64>,
    /// C_g B^-1 U K^1/2.
    along: Matrix,
    trace: f64,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum What {
    Size,
    Length,
    Noise,
}

impl Likelihood<'_> {
    /// As [`Likelihood::block`], for C = B + U K U' with B = D + s^2 R(length) in parts.
    pub(crate) fn kernelled_block(
        &self,
        structured: &Structured,
        (k, known): (&Kernelled, &KernelFactor),
        order: Order,
    ) -> Block {
        let (n, p) = (self.observation.values.len(), self.parameters);
        let residual =
            Matrix::from_fn(n, 1, |i, _| self.prediction.values[self.first + i] - self.observation.values[i]);
        let alpha = known.solve(k, &residual);
        let square = dot(residual.as_slice(), alpha.as_slice());
        let ln_likelihood = -0.5 * (square + known.ln_det + n as f64 * (2.0 * PI).ln());
        let mut block = Block { ln_likelihood, ..Block::default() };
        if order == Order::Value {
            return block;
        }
        let size = p + self.floating.len();
        block.gradient = vec![0.0; size];
        block.gauss_newton = Matrix::zeros(size, size);
        let jacobian = Matrix::from_fn(n, p, |i, j| self.prediction.jacobian[(self.first + i, j)]);
        for j in 0..p {
            block.gradient[j] = (0..n).map(|i| jacobian[(i, j)] * alpha[(i, 0)]).sum();
        }
        let mut turned = Matrix::zeros(n, 0);
        if (order == Order::Second || self.floating.is_empty()) && p > 0 {
            turned = known.solve(k, &jacobian);
            for i in 0..p {
                for j in 0..p {
                    block.gauss_newton[(i, j)] = (0..n).map(|r| jacobian[(r, i)] * turned[(r, j)]).sum();
                }
            }
        }
        if order == Order::Second && p > 0 && !self.prediction.curvature.is_empty() {
            block.curvature = self.bend(alpha.as_slice());
        }
        self.add_kernel_noise(&mut block, structured, (k, known), (&alpha, &turned), order);
        block
    }

    /// Derivatives with respect to ln of floating sizes and of the length. With a = C^-1 r, W = B^-1 U K^1/2,
    /// C^-1 = B^-1 - W M^-1 W': dJ/du_g = (tr C^-1 C_g - a'C_g a)/2, d2J/du_g du_h = (tr C^-1 C_gh - tr C^-1
    /// C_g C^-1 C_h - a'C_gh a)/2 + a'C_g C^-1 C_h a, d2J/dz du_g = -F'C^-1 C_g a.
    fn add_kernel_noise(
        &self,
        block: &mut Block,
        structured: &Structured,
        (k, known): (&Kernelled, &KernelFactor),
        (alpha, turned): (&Matrix, &Matrix),
        order: Order,
    ) {
        let (p, n, q) = (self.parameters, alpha.rows(), known.columns.columns());
        let inverse = if q > 0 { known.factor.inverse() } else { Matrix::default() };
        let within = |a: &Matrix, b: &Matrix| {
            if q == 0 { 0.0 } else { dot(a.transpose().large_product(b).as_slice(), inverse.as_slice()) }
        };
        let noise = |group: usize, factor: f64| {
            let mut d = vec![0.0; n];
            for (_, s) in structured.noise.iter().filter(|(g, _)| *g == group) {
                d.iter_mut().zip(s).for_each(|(d, s)| *d += factor * self.sds[group].powi(2) * s);
            }
            d
        };
        let times = |what: What, group: usize, x: &Matrix| match what {
            What::Size => known.inside(k, x, |part| &part.slopes[0]),
            What::Length => known.inside(k, x, |part| &part.slopes[1]),
            What::Noise => {
                let d = noise(group, 2.0);
                Matrix::from_fn(n, x.columns(), |i, j| d[i] * x[(i, j)])
            }
        };
        let mut acting = Vec::new();
        for (c, &group) in self.floating.iter().enumerate() {
            let what = if group == k.size {
                What::Size
            } else if group == k.length {
                What::Length
            } else if structured.noise.iter().any(|(g, _)| *g == group) {
                What::Noise
            } else {
                continue;
            };
            let along = times(what, group, &known.solved);
            let own = match what {
                What::Noise => {
                    let d = noise(group, 2.0);
                    let parts = k.parts.iter().zip(&known.of);
                    let one = |(rows, &index): (&Vec<usize>, &usize)| -> f64 {
                        rows.iter().enumerate().map(|(i, r)| d[*r] * known.parts[index].inverse[(i, i)]).sum()
                    };
                    parts.map(one).sum::<f64>()
                }
                _ => {
                    let g = usize::from(what == What::Length);
                    known.of.iter().map(|&index| trace(&known.parts[index].turned[g])).sum()
                }
            };
            let trace = own - within(&known.solved, &along);
            let pull = times(what, group, alpha).as_slice().to_vec();
            acting.push(Acting { group, coordinate: p + c, what, pull, along, trace });
        }
        for (index, x) in acting.iter().enumerate() {
            block.gradient[x.coordinate] += 0.5 * (x.trace - dot(&x.pull, alpha.as_slice()));
            if order < Order::Second {
                continue;
            }
            for i in 0..p {
                let slope: f64 = (0..n).map(|r| turned[(r, i)] * x.pull[r]).sum();
                add_symmetric(&mut block.gauss_newton, x.coordinate, i, -slope);
            }
            let pull = Matrix::from_fn(n, 1, |i, _| x.pull[i]);
            let answer = known.solve(k, &pull);
            for (other, y) in acting[..=index].iter().enumerate() {
                let force = dot(answer.as_slice(), &y.pull);
                let second = self.second((k, known), (x, y), alpha, &within);
                let bend =
                    0.5 * (second - product(structured, self.sds, (k, known), (x, y), &inverse)) + force;
                block.gauss_newton[(x.coordinate, y.coordinate)] += bend;
                if other < index {
                    block.gauss_newton[(y.coordinate, x.coordinate)] += bend;
                }
            }
        }
    }

    /// tr C^-1 C_gh - a'C_gh a.
    fn second(
        &self,
        (k, known): (&Kernelled, &KernelFactor),
        (x, y): (&Acting, &Acting),
        alpha: &Matrix,
        within: &dyn Fn(&Matrix, &Matrix) -> f64,
    ) -> f64 {
        let bend = match (x.what, y.what) {
            (What::Size, What::Size) => 0,
            (What::Length, What::Length) => 1,
            (What::Size, What::Length) | (What::Length, What::Size) => 2,
            // The variance of a noise is twice its own slope again; different noises and the misfit add up.
            (What::Noise, What::Noise) if x.group == y.group => {
                return 2.0 * (x.trace - dot(&x.pull, alpha.as_slice()));
            }
            _ => return 0.0,
        };
        let own: f64 = known
            .of
            .iter()
            .map(|&index| {
                dot(known.parts[index].inverse.as_slice(), known.parts[index].bends[bend].as_slice())
            })
            .sum();
        let along = known.inside(k, &known.solved, |part| &part.bends[bend]);
        let pulled = known.inside(k, alpha, |part| &part.bends[bend]);
        own - within(&known.solved, &along) - dot(pulled.as_slice(), alpha.as_slice())
    }
}

/// tr C^-1 C_g C^-1 C_h.
fn product(
    structured: &Structured,
    sds: &[f64],
    (k, known): (&Kernelled, &KernelFactor),
    (x, y): (&Acting, &Acting),
    inverse: &Matrix,
) -> f64 {
    // B^-1 C_g of each part.
    let turned = |a: &Acting, rows: &[usize], index: usize| -> Matrix {
        let part = &known.parts[index];
        match a.what {
            What::Size => part.turned[0].clone(),
            What::Length => part.turned[1].clone(),
            What::Noise => {
                let d = |row: usize| -> f64 {
                    let own = structured.noise.iter().filter(|(g, _)| *g == a.group);
                    own.map(|(_, s)| 2.0 * sds[a.group].powi(2) * s[row]).sum()
                };
                Matrix::from_fn(rows.len(), rows.len(), |i, j| part.inverse[(i, j)] * d(rows[j]))
            }
        }
    };
    let mut sum = 0.0;
    let mut same: Vec<(usize, f64)> = Vec::new();
    let plain = structured.noise.iter().all(|(_, s)| s.iter().all(|v| *v == s[0]));
    for (rows, &index) in k.parts.iter().zip(&known.of) {
        let found = same.iter().find(|(i, _)| *i == index && plain).map(|(_, v)| *v);
        sum += found.unwrap_or_else(|| {
            let (a, b) = (turned(x, rows, index), turned(y, rows, index));
            let value = dot(a.as_slice(), b.transpose().as_slice());
            same.push((index, value));
            value
        });
    }
    let q = known.columns.columns();
    if q > 0 {
        let back = known.inside(k, &y.along, |part| &part.inverse);
        sum -= 2.0 * dot(x.along.transpose().large_product(&back).as_slice(), inverse.as_slice());
        let [a, b] = [x, y].map(|a| inverse.large_product(&known.solved.transpose().large_product(&a.along)));
        sum += dot(a.as_slice(), b.transpose().as_slice());
    }
    sum
}

fn trace(m: &Matrix) -> f64 {
    (0..m.rows()).map(|i| m[(i, i)]).sum()
}
