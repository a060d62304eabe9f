//! A model with its data to first order about a fit: what further directions would gain, and what each datum
//! is worth.
//!
//! With C the covariance of the data, F the derivatives of the prediction and Sigma0 the prior covariance of
//! the parameters, the data scatter about the prediction of the prior mean with the covariance V = C + F
//! Sigma0 F'. Its inverse, P = C^-1 - C^-1 F Sigma F' C^-1 with Sigma the posterior covariance, takes out of
//! a direction what the parameters can do as well. At the fit P times the residual from the prior mean is
//! C^-1 r, with r the residual of the fit.
//!
//! Knows one fit and the derivatives there: no model is called again.

mod causes;
mod few;
mod left_out;
mod moved;

use crate::covariance::dense_enough;
use crate::{Fit, InferenceError, Laplace, NoiseMode, Posterior};
use rijke_numerics::{Cholesky, Matrix, Order, Stream, dot, symmetric_eigen};
use std::ops::Range;

pub use causes::Causes;
pub use few::{Few, student};
pub use left_out::LeftOut;
pub use moved::Moved;

/// A model with its data to first order about a fit, with noise as fitted.
#[derive(Clone, Debug)]
pub struct Linearised {
    /// Measured minus predicted.
    pub residuals: Vec<f64>,
    blocks: Vec<Block>,
    /// C^-1 r.
    pulls: Vec<f64>,
    /// C^-1 F S with S S' = Sigma: a row for each datum.
    learnt: Matrix,
    /// S': a column for each parameter.
    root: Matrix,
    /// Root of 1 - S' F' C^-1 F S: what of each parameter the prior tells.
    untold: Matrix,
    /// The noises that the data choose.
    floating: Vec<Floating>,
}

/// Data that are correlated with each other.
#[derive(Clone, Debug)]
struct Block {
    first: usize,
    covariance: Matrix,
    factor: Cholesky,
    inverse: Matrix,
}

/// A noise whose standard deviation the data choose: its part of each block's covariance.
#[derive(Clone, Debug)]
struct Floating {
    /// Its place among the groups of noise.
    group: usize,
    parts: Vec<Part>,
    /// Trace of C^-1 times its covariance: how many data it explains.
    count: f64,
    /// The least part of the variance that is left without it.
    floor: f64,
    /// What it explains now, r' C^-1 S C^-1 r, and the precision of ln sd in its prior.
    explained: f64,
    precision: f64,
}

/// What a noise is to one block.
#[derive(Clone, Debug)]
struct Part {
    block: usize,
    /// Its part S of the block's covariance.
    covariance: Matrix,
    /// L'S L, with L the block's rows of what is learnt.
    learnt: Matrix,
}

/// What the data say of one more direction in which the prediction could move.
#[derive(Clone, Debug, PartialEq)]
pub struct Told {
    /// P times the direction.
    pub pulled: Vec<f64>,
    /// Most probable strength, without prior.
    pub strength: f64,
    /// Its standard deviation, the parameters being free to follow.
    pub sd: f64,
    /// Share of the information about it that the parameters leave: 1 for a direction that none of them can
    /// imitate.
    pub left: f64,
    /// Drop of -ln likelihood at that strength, nats: noise as fitted, and noise chosen again.
    pub drop: [f64; 2],
    /// Share of each floating noise in the variance of the strength.
    pub shares: Vec<f64>,
}

impl Told {
    /// ln Bayes factor for the model with this direction, for a drop of -ln likelihood: its strength has a
    /// normal prior about zero whose standard deviation is what one of `observations` data sets alone would
    /// leave if everything else were known (unit information, Kass & Wasserman, J. Am. Stat. Assoc. 90 (1995)
    /// 928).
    #[must_use]
    pub fn gain(&self, drop: f64, observations: usize) -> f64 {
        gain(drop, self.left * observations as f64)
    }

    /// Standard deviation of that prior.
    #[must_use]
    pub fn prior_sd(&self, observations: usize) -> f64 {
        self.sd * (self.left * observations as f64).sqrt()
    }
}

/// ln Bayes factor for one more direction of a linear model: `drop` is that of -ln likelihood at its best
/// strength, `ratio` the variance of the prior of that strength over the variance that the data leave.
#[must_use]
pub fn gain(drop: f64, ratio: f64) -> f64 {
    drop * ratio / (1.0 + ratio) - 0.5 * ratio.ln_1p()
}

/// A draw of data by the model's own predictive density.
#[derive(Clone, Debug)]
pub struct Drawn {
    /// P times the residual from the prior mean.
    pub pulls: Vec<f64>,
    /// What the variance of each floating noise would be estimated at, in that of the fit.
    pub noise: Vec<f64>,
}

impl Posterior<'_> {
    /// The model and its data to first order about `fit`.
    ///
    /// # Errors
    /// Those of the model, and [`InferenceError::Dense`].
    pub fn linearised(&self, fit: &Fit, laplace: &Laplace) -> Result<Linearised, InferenceError> {
        let (sds, p) = (self.noise_sd(&fit.working), self.parameters().len());
        let prediction = self.predict(&fit.parameters, Order::First)?;
        let slopes: Vec<f64> =
            self.parameters().list().iter().zip(&fit.working).map(|(q, &z)| q.physical(z)[1]).collect();
        let own: Vec<usize> = (0..p).collect();
        let information = Cholesky::new(&laplace.gauss_newton.plus(1.0, &laplace.prior).select(&own))?;
        let mut floating: Vec<(usize, Floating)> = self
            .floating()
            .iter()
            .map(|g| {
                let precision = match self.data().groups()[*g].mode {
                    NoiseMode::Inferred { ln_sd, .. } => ln_sd.powi(-2),
                    _ => 0.0,
                };
                let group = *g;
                (
                    group,
                    Floating { group, parts: Vec::new(), count: 0.0, floor: 1.0, explained: 0.0, precision },
                )
            })
            .collect();
        let (mut residuals, mut pulls, mut blocks) = (Vec::new(), Vec::new(), Vec::new());
        let mut learnt = Matrix::zeros(self.data().size(), p);
        for (k, observation) in self.data().observations().iter().enumerate() {
            let (first, n) = (residuals.len(), observation.values.len());
            dense_enough(&observation.label, n)?;
            let covariance = self.covariance(k, &sds);
            let factor = Cholesky::new(&covariance)?;
            let inverse = factor.inverse();
            residuals.extend((0..n).map(|i| observation.values[i] - prediction.values[first + i]));
            pulls.extend(factor.solve(&residuals[first..]));
            let f = Matrix::from_fn(n, p, |i, j| prediction.jacobian[(first + i, j)] * slopes[j]);
            let turned = inverse.product(&f);
            for i in 0..n {
                for (j, v) in information.whiten(turned.row(i)).into_iter().enumerate() {
                    learnt[(first + i, j)] = v;
                }
            }
            for (group, noise) in &mut floating {
                for (_, structure) in observation.noise.iter().filter(|(g, _)| g == group) {
                    let part = Matrix::from_fn(n, n, |i, j| sds[*group].powi(2) * structure[(i, j)]);
                    noise.count +=
                        part.as_slice().iter().zip(inverse.as_slice()).map(|(a, b)| a * b).sum::<f64>();
                    for i in (0..n).filter(|&i| part[(i, i)] > 0.0) {
                        noise.floor = noise.floor.min(1.0 - part[(i, i)] / covariance[(i, i)]);
                    }
                    noise.parts.push(Part { block: k, covariance: part, learnt: Matrix::default() });
                }
            }
            blocks.push(Block { first, covariance, factor, inverse });
        }
        let unit = |j: usize| (0..p).map(|i| f64::from(u8::from(i == j))).collect::<Vec<f64>>();
        let whitened: Vec<Vec<f64>> = (0..p).map(|j| information.whiten(&unit(j))).collect();
        Linearised {
            residuals,
            blocks,
            pulls,
            learnt,
            root: Matrix::from_fn(p, p, |i, j| whitened[j][i]),
            untold: Matrix::zeros(p, p),
            floating: floating.into_iter().map(|(_, f)| f).filter(|f| f.count > 0.0).collect(),
        }
        .settled()
    }
}

impl Linearised {
    /// With everything that follows from what is learnt and from the pulls.
    fn settled(mut self) -> Result<Self, InferenceError> {
        for k in 0..self.floating.len() {
            for i in 0..self.floating[k].parts.len() {
                let part = &self.floating[k].parts[i];
                let range = self.own(part);
                let own = Matrix::from_fn(range.len(), self.learnt.columns(), |r, j| {
                    self.learnt[(range.start + r, j)]
                });
                self.floating[k].parts[i].learnt = own.transpose().product(&part.covariance.product(&own));
            }
            self.floating[k].explained = self.within(&self.floating[k], &self.pulls, &self.pulls);
        }
        let p = self.learnt.columns();
        let columns: Vec<Vec<f64>> =
            (0..p).map(|j| (0..self.learnt.rows()).map(|i| self.learnt[(i, j)]).collect()).collect();
        let moved: Vec<Vec<f64>> = columns.iter().map(|c| self.with_covariance(c)).collect();
        let rest = Matrix::from_fn(p, p, |i, j| f64::from(u8::from(i == j)) - dot(&columns[i], &moved[j]));
        let (values, vectors) = symmetric_eigen(&rest)?;
        self.untold = Matrix::from_fn(p, p, |i, j| vectors[(i, j)] * values[j].max(0.0).sqrt());
        Ok(self)
    }

    /// C v.
    fn with_covariance(&self, v: &[f64]) -> Vec<f64> {
        self.blocks
            .iter()
            .flat_map(|b| b.covariance.times(&v[b.first..b.first + b.covariance.rows()]))
            .collect()
    }

    /// S v for the covariance of a floating noise.
    fn through(&self, noise: &Floating, v: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; v.len()];
        for part in &noise.parts {
            let own = self.own(part);
            let found = part.covariance.times(&v[own.clone()]);
            out[own].iter_mut().zip(found).for_each(|(o, f)| *o += f);
        }
        out
    }

    /// The places of the data of a part.
    fn own(&self, part: &Part) -> Range<usize> {
        let first = self.blocks[part.block].first;
        first..first + part.covariance.rows()
    }

    /// v' S u for the covariance of a floating noise.
    fn within(&self, noise: &Floating, v: &[f64], u: &[f64]) -> f64 {
        let one = |part: &Part| {
            let own = self.own(part);
            dot(&v[own.clone()], &part.covariance.times(&u[own]))
        };
        noise.parts.iter().map(one).sum()
    }

    /// C^-1 v.
    fn weighed(&self, v: &[f64]) -> Vec<f64> {
        let own = |b: &Block| b.inverse.times(&v[b.first..b.first + b.inverse.rows()]);
        self.blocks.iter().flat_map(own).collect()
    }

    /// P v.
    fn pulled(&self, v: &[f64]) -> Vec<f64> {
        let (mut out, told) = (self.weighed(v), self.told_by(v));
        for (i, o) in out.iter_mut().enumerate() {
            *o -= dot(self.learnt.row(i), &told);
        }
        out
    }

    /// S' F' C^-1 v.
    fn told_by(&self, v: &[f64]) -> Vec<f64> {
        let mut told = vec![0.0; self.learnt.columns()];
        for (i, v) in v.iter().enumerate() {
            told.iter_mut().zip(self.learnt.row(i)).for_each(|(t, l)| *t += l * v);
        }
        told
    }

    /// C^-1 r, which is P times the residual from the mean of the prior.
    #[must_use]
    pub fn pulls(&self) -> &[f64] {
        &self.pulls
    }

    /// What the data say of a direction, the change of every datum's prediction per strength; none where it
    /// moves nothing.
    ///
    /// # Panics
    /// If `direction` has more numbers than there are data.
    #[must_use]
    pub fn told(&self, direction: &[f64]) -> Option<Told> {
        let pulled = self.pulled(direction);
        let information = dot(direction, &pulled);
        let whole = information + self.told_by(direction).iter().map(|t| t * t).sum::<f64>();
        if !(whole > 0.0 && information > SEEN * whole) {
            return None;
        }
        let strength = dot(direction, &self.pulls) / information;
        let drop = 0.5 * strength * strength * information;
        let after: Vec<f64> = self.pulls.iter().zip(&pulled).map(|(a, b)| a - strength * b).collect();
        let spread = dot(&pulled, &self.with_covariance(&pulled));
        let shares = |noise: &Floating| self.within(noise, &pulled, &pulled) / spread;
        Some(Told {
            strength,
            sd: information.sqrt().recip(),
            left: information / whole,
            drop: [drop, drop + self.noise_gains(&after).max(0.0)],
            shares: self.floating.iter().map(shares).collect(),
            pulled,
        })
    }

    /// What -ln likelihood falls by where residuals belong to these `pulls` and floating noise is chosen
    /// again, nats.
    fn noise_gains(&self, pulls: &[f64]) -> f64 {
        let again = |noise: &Floating| {
            // As if each noise had `count` data to itself: half count times (x - ln v - x/v), at its least
            // over the variance v that the floor allows.
            let x = self.within(noise, pulls, pulls) / noise.count;
            let v = x.max(noise.floor).max(f64::EPSILON);
            0.5 * noise.count * (x - v.ln() - x / v)
        };
        self.floating.iter().map(again).sum()
    }

    /// Data by the model's own predictive density: parameters by their prior, noise as fitted.
    pub fn draw(&self, stream: &mut Stream) -> Drawn {
        use rand::RngExt;
        let mut normal =
            |n: usize| -> Vec<f64> { (0..n).map(|_| stream.sample(rand_distr::StandardNormal)).collect() };
        let noise: Vec<f64> =
            self.blocks.iter().flat_map(|b| b.factor.lower().times(&normal(b.covariance.rows()))).collect();
        let prior = self.untold.times(&normal(self.untold.rows()));
        let mut pulls = self.pulled(&noise);
        for (i, p) in pulls.iter_mut().enumerate() {
            *p += dot(self.learnt.row(i), &prior);
        }
        let noise =
            self.floating.iter().map(|f| (self.within(f, &pulls, &pulls) / f.count).max(f.floor)).collect();
        Drawn { pulls, noise }
    }

    /// The sum of squares of residuals in the standard deviations of the noise, of the data at `places`, for
    /// residuals that belong to these `pulls`: [`Linearised::pulls`], or those of a draw.
    #[must_use]
    pub fn squares(&self, pulls: &[f64], places: &[usize]) -> f64 {
        let residuals = self.with_covariance(pulls);
        places.iter().map(|&i| residuals[i].powi(2) / self.variance(i)).sum()
    }

    /// Share of the variance of a datum that the data choose themselves.
    ///
    /// # Panics
    /// If there is no datum at `place`.
    #[must_use]
    pub fn floats(&self, place: usize) -> f64 {
        let block = self.blocks.partition_point(|b| b.first <= place) - 1;
        let at = place - self.blocks[block].first;
        let parts = self.floating.iter().flat_map(|f| &f.parts).filter(|part| part.block == block);
        parts.map(|part| part.covariance[(at, at)]).sum::<f64>() / self.variance(place)
    }

    fn variance(&self, place: usize) -> f64 {
        let block = &self.blocks[self.blocks.partition_point(|b| b.first <= place) - 1];
        block.covariance[(place - block.first, place - block.first)]
    }
}

/// Share of the information below which a direction is one of the parameters.
const SEEN: f64 = 1e-6;
