//! Scores that all runs share and scores of each run, in equations of the shape of an arrow: run by run, at a
//! cost that grows with their number.
//!
//! The score of unknown k in run p is a_k s_k + (1 - a_k^2)^(1/2) o_pk. Given the shared s, runs know nothing
//! of each other, so the own scores are eliminated one run after the other (a Schur complement; Golub & Van
//! Loan, Matrix Computations, section 3.4).

use super::unknowns::{FIXED, shared_share};
use rijke_numerics::{Cholesky, DenseError, Matrix};

/// Scores, or their changes.
#[derive(Clone, Debug)]
pub(super) struct Scores {
    shared: Vec<f64>,
    own: Vec<Vec<f64>>,
}

/// The posterior of all scores, where information is that of the readings on the scores of each run.
pub(super) struct Arrow {
    /// Covariance of the shared scores.
    pub(super) shared: Matrix,
    parts: Vec<Part>,
}

/// What one run adds: covariance of its own scores given the shared ones, and how its own scores follow
/// those, with the sign changed.
struct Part {
    own: Matrix,
    coupling: Matrix,
    follow: Matrix,
}

/// Shares a_k and (1 - a_k^2)^(1/2).
fn shares(k: usize) -> [f64; 2] {
    let share = if k < FIXED { shared_share(k) } else { 0.0 };
    [share, (1.0 - share * share).sqrt()]
}

impl Scores {
    /// The centre of the prior; `sizes` are the numbers of scores of the runs.
    pub(super) fn centre(sizes: impl Iterator<Item = usize>) -> Self {
        Self { shared: vec![0.0; FIXED], own: sizes.map(|n| vec![0.0; n]).collect() }
    }

    /// The scores of run `p`.
    pub(super) fn of(&self, p: usize) -> Vec<f64> {
        let one = |(k, own): (usize, &f64)| {
            let [a, b] = shares(k);
            if k < FIXED { a * self.shared[k] + b * own } else { *own }
        };
        self.own[p].iter().enumerate().map(one).collect()
    }

    /// The negative gradient of the cost, where `by_run` is that of the misfit in the scores of each run.
    pub(super) fn descent<'a>(&self, by_run: impl Iterator<Item = &'a [f64]>) -> Self {
        let mut down = self.plus(-2.0, self);
        for (own, slopes) in down.own.iter_mut().zip(by_run) {
            for (k, (own, slope)) in own.iter_mut().zip(slopes).enumerate() {
                let [a, b] = shares(k);
                *own += b * slope;
                if k < FIXED {
                    down.shared[k] += a * slope;
                }
            }
        }
        down
    }

    pub(super) fn plus(&self, factor: f64, other: &Self) -> Self {
        let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + factor * b).collect::<Vec<f64>>();
        let own = self.own.iter().zip(&other.own).map(|(a, b)| sum(a, b)).collect();
        Self { shared: sum(&self.shared, &other.shared), own }
    }

    pub(super) fn dot(&self, other: &Self) -> f64 {
        let all = |s: &Self| s.shared.iter().chain(s.own.iter().flatten()).copied().collect::<Vec<f64>>();
        all(self).iter().zip(all(other)).map(|(a, b)| a * b).sum()
    }
}

impl Arrow {
    /// From the `information` of each run, with the precision of the prior at 1 + `damping`.
    pub(super) fn new<'a>(
        information: impl Iterator<Item = &'a Matrix>,
        damping: f64,
    ) -> Result<Self, DenseError> {
        let identity = |n: usize| Matrix::diagonal(&vec![1.0 + damping; n]);
        let mut precision = identity(FIXED);
        let part = |information: &Matrix| {
            let n = information.rows();
            let between =
                |i: usize, j: usize, [a, b]: [usize; 2]| shares(i)[a] * information[(i, j)] * shares(j)[b];
            let own = identity(n).plus(1.0, &Matrix::from_fn(n, n, |i, j| between(i, j, [1, 1])));
            let coupling = Matrix::from_fn(n, FIXED, |i, j| between(i, j, [1, 0]));
            let own = Cholesky::new(&own)?.inverse();
            let follow = own.product(&coupling);
            precision = precision.plus(1.0, &Matrix::from_fn(FIXED, FIXED, |i, j| between(i, j, [0, 0])));
            precision = precision.plus(-1.0, &coupling.transpose().product(&follow));
            Ok(Part { own, coupling, follow })
        };
        let parts = information.map(part).collect::<Result<Vec<_>, DenseError>>()?;
        Ok(Self { shared: Cholesky::new(&precision)?.inverse(), parts })
    }

    /// Newton's step down the slope `down`.
    pub(super) fn step(&self, down: &Scores) -> Scores {
        let mut right = down.shared.clone();
        for (part, own) in self.parts.iter().zip(&down.own) {
            let less = part.follow.transpose().times(own);
            right.iter_mut().zip(less).for_each(|(r, l)| *r -= l);
        }
        let shared = self.shared.times(&right);
        let own = self.parts.iter().zip(&down.own).map(|(part, own)| {
            let pull = part.coupling.times(&shared);
            part.own.times(&own.iter().zip(pull).map(|(o, p)| o - p).collect::<Vec<f64>>())
        });
        Scores { own: own.collect(), shared }
    }

    /// Of run `p`: how its scores follow the shared ones, and their covariance given those.
    pub(super) fn of(&self, p: usize) -> (Matrix, Matrix) {
        let Part { own, follow, .. } = &self.parts[p];
        let n = own.rows();
        let along = Matrix::from_fn(n, FIXED, |i, j| {
            (if i == j { shares(i)[0] } else { 0.0 }) - shares(i)[1] * follow[(i, j)]
        });
        (along, Matrix::from_fn(n, n, |i, j| shares(i)[1] * own[(i, j)] * shares(j)[1]))
    }
}
