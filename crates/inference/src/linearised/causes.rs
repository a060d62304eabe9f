//! What data tell of causes that move several of them at once and stand in their covariance.

use super::Linearised;
use rijke_numerics::{Matrix, dot};

/// The posterior of such causes, jointly with the parameters.
#[derive(Clone, Debug)]
pub struct Causes {
    /// Mean of each.
    pub mean: Vec<f64>,
    /// Their covariance.
    pub covariance: Matrix,
    /// Covariance with the working coordinates of the parameters: a row for each cause.
    pub with_parameters: Matrix,
}

impl Linearised {
    /// The posterior of causes u that are normal about zero with these standard deviations, are part of the
    /// noise, and move the data by their `columns`.
    ///
    /// With D the prior covariance of u, S the columns, and P as on the first page of this folder, the mean
    /// is D S' C^-1 r, the covariance D - D S' P S D, and that with the parameters -D S' C^-1 F Sigma.
    #[must_use]
    pub fn causes(&self, columns: &[Vec<f64>], sds: &[f64]) -> Causes {
        let pulled: Vec<Vec<f64>> = columns.iter().map(|s| self.pulled(s)).collect();
        let told: Vec<Vec<f64>> = columns.iter().map(|s| self.told_by(s)).collect();
        let (n, p) = (columns.len(), self.root.columns());
        let variance = |k: usize| sds[k] * sds[k];
        let along = |k: usize, i: usize| (0..p).map(|j| self.root[(j, i)] * told[k][j]).sum::<f64>();
        Causes {
            mean: (0..n).map(|k| variance(k) * dot(&columns[k], &self.pulls)).collect(),
            covariance: Matrix::from_fn(n, n, |k, l| {
                let own = if k == l { variance(k) } else { 0.0 };
                own - variance(k) * dot(&columns[k], &pulled[l]) * variance(l)
            }),
            with_parameters: Matrix::from_fn(n, p, |k, i| -variance(k) * along(k, i)),
        }
    }
}
