//! What a model says together of numbers that could be measured, as one Gaussian, and what measuring some of them would tell.
//!
//! With y the numbers, J their derivatives in what is known to Sigma (parameters, and errors that the training found), E the errors that
//! points share and N the noise of each visit, y has the covariance V = J Sigma J' + E + N. Whatever is chosen to be measured is a selection of
//! rows, so that what points share is counted once.

use crate::EngineError;
use rijke_numerics::{Cholesky, Matrix};
use rijke_study::Cause;
use std::collections::BTreeMap;

/// Who shares an error.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Shared {
    /// All points that name the cause.
    Cause(Cause),
    /// The points of one installation: growth rate (0) or angular frequency (1).
    Installation(usize, String),
    /// The points of one installation: a parameter that differs from installation to installation.
    Varying(String, String),
}

/// The numbers of one operating point to first order.
#[derive(Clone, Debug, Default)]
pub(super) struct Numbers {
    pub(super) values: Vec<f64>,
    /// Place in what is known, and the derivative in it.
    pub(super) along: Vec<(usize, Vec<f64>)>,
    /// The change per standard deviation of each error that points share.
    pub(super) shared: BTreeMap<Shared, Vec<f64>>,
    /// Variance of the noise of one visit; zero for a quantity that is wanted and not measured.
    pub(super) noise: Vec<f64>,
}

/// The joint predictive of operating points by one model.
#[derive(Clone, Debug)]
pub(super) struct Predictive {
    points: Vec<Numbers>,
    /// Where the rows of each point start.
    starts: Vec<usize>,
    /// J Sigma J'.
    signal: Matrix,
    /// E.
    shared: Matrix,
}

impl Predictive {
    /// From the points and the covariance of what is known.
    pub(super) fn new(points: Vec<Numbers>, covariance: &Matrix) -> Self {
        let starts: Vec<usize> = points
            .iter()
            .scan(0, |next, p| {
                let start = *next;
                *next += p.values.len();
                Some(start)
            })
            .collect();
        let rows: usize = points.iter().map(|p| p.values.len()).sum();
        let mut jacobian = Matrix::zeros(rows, covariance.rows());
        for (point, start) in points.iter().zip(&starts) {
            for (place, slope) in &point.along {
                slope.iter().enumerate().for_each(|(row, d)| jacobian[(start + row, *place)] += d);
            }
        }
        let signal = jacobian.product(covariance).product(&jacobian.transpose());
        let mut shared = Matrix::zeros(rows, rows);
        for (a, from) in points.iter().zip(&starts) {
            for (b, to) in points.iter().zip(&starts) {
                for (cause, slope) in &a.shared {
                    let Some(other) = b.shared.get(cause) else { continue };
                    for (i, x) in slope.iter().enumerate() {
                        other.iter().enumerate().for_each(|(j, y)| shared[(from + i, to + j)] += x * y);
                    }
                }
            }
        }
        Self { points, starts, signal, shared }
    }

    /// The rows of the visits `set`, each with the visit that it belongs to.
    fn rows(&self, set: &[usize]) -> Vec<(usize, usize)> {
        let of = |(visit, &k): (usize, &usize)| {
            (0..self.points[k].values.len()).map(move |i| (visit, self.starts[k] + i))
        };
        set.iter().enumerate().flat_map(of).collect()
    }

    /// The covariance of what the visits would bring if all parameters were known: a repeat has noise of its own, and the same shared errors.
    fn errors(&self, set: &[usize]) -> Matrix {
        let rows = self.rows(set);
        Matrix::from_fn(rows.len(), rows.len(), |i, j| {
            let ((visit, a), (other, b)) = (rows[i], rows[j]);
            let noise = if a == b && visit == other {
                let k = set[visit];
                self.points[k].noise[a - self.starts[k]]
            } else {
                0.0
            };
            self.shared[(a, b)] + noise
        })
    }

    fn covariance(&self, set: &[usize]) -> Matrix {
        let rows = self.rows(set);
        let mut v = self.errors(set);
        for (i, (_, a)) in rows.iter().enumerate() {
            rows.iter().enumerate().for_each(|(j, (_, b))| v[(i, j)] += self.signal[(*a, *b)]);
        }
        v
    }

    fn mean(&self, set: &[usize]) -> Vec<f64> {
        set.iter().flat_map(|&k| self.points[k].values.iter().copied()).collect()
    }

    /// What the visits `set` would tell of the parameters, nats: the expected Kullback-Leibler divergence of posterior from prior, which is
    /// (1/2) ln det (E + N)^-1 V (Lindley 1956; with the derivatives of the adjoint, Yoko & Juniper 2024).
    pub(super) fn information(&self, set: &[usize]) -> Result<f64, EngineError> {
        let (v, e) = (Cholesky::new(&self.covariance(set))?, Cholesky::new(&self.errors(set))?);
        Ok(0.5 * (v.ln_det() - e.ln_det()))
    }

    /// Variance of the first number of point `quantity` before, and after the visits `set`.
    pub(super) fn variances(&self, quantity: usize, set: &[usize]) -> Result<[f64; 2], EngineError> {
        let q = self.starts[quantity];
        let before = self.signal[(q, q)] + self.shared[(q, q)];
        let with: Vec<f64> =
            self.rows(set).iter().map(|(_, a)| self.signal[(*a, q)] + self.shared[(*a, q)]).collect();
        let v = Cholesky::new(&self.covariance(set))?;
        let told: f64 = v.whiten(&with).iter().map(|w| w * w).sum();
        Ok([before, before - told])
    }

    /// The expected logarithm of the Bayes factor for `self` against `other` by the visits `set` if `self` is right, nats: the Kullback-Leibler
    /// divergence of the two predictives.
    pub(super) fn divergence(&self, other: &Self, set: &[usize]) -> Result<f64, EngineError> {
        let (mine, theirs) = (self.covariance(set), other.covariance(set));
        let (own, their) = (Cholesky::new(&mine)?, Cholesky::new(&theirs)?);
        let squared = |v: &[f64]| their.whiten(v).iter().map(|w| w * w).sum::<f64>();
        // tr(B^-1 A) with A = L L' is the sum over the columns of L.
        let l = own.lower();
        let n = l.rows();
        let trace: f64 = (0..n).map(|j| squared(&(0..n).map(|i| l[(i, j)]).collect::<Vec<_>>())).sum();
        let apart: Vec<f64> = self.mean(set).iter().zip(other.mean(set)).map(|(a, b)| a - b).collect();
        Ok(0.5 * (trace - n as f64 + squared(&apart) + their.ln_det() - own.ln_det()))
    }
}
