//! What data tell of causes that move several of them at once and stand in their covariance.

use super::Linearised;
use crate::InferenceError;
use rijke_numerics::{Cholesky, Matrix, dot, forward};

/// What data tell of such causes beside the parameters. With Sigma the posterior covariance of the
/// parameters, by whatever approximation, the causes have the covariance `given` + `along` Sigma `along`',
/// and `along` Sigma with the parameters.
#[derive(Clone, Debug)]
pub struct Causes {
    /// Mean of each.
    pub mean: Vec<f64>,
    /// Their covariance if the parameters were known.
    pub given: Matrix,
    /// By how much the mean of each moves per working coordinate of a parameter: a row for each cause.
    pub along: Matrix,
}

impl Linearised {
    /// The posterior of causes u that are normal about zero with these standard deviations, are part of the
    /// noise, and move the data by their `columns`; of a model without the errors of
    /// [`Linearised::with_shared`].
    ///
    /// With D the prior covariance of u and S the columns, the mean is D S' C^-1 r, the covariance for known
    /// parameters D - D S' C^-1 S D, and the mean moves with the parameters by -D S' C^-1 F.
    ///
    /// # Panics
    /// Unless every column has a number for each datum, and there are as many `sds` as columns.
    #[must_use]
    pub fn causes(&self, columns: &[Vec<f64>], sds: &[f64]) -> Causes {
        let (n, p) = (columns.len(), self.root.columns());
        let weighed: Vec<Vec<f64>> = columns.iter().map(|s| self.weighed(s)).collect();
        // F' C^-1 s.
        let slopes: Vec<Vec<f64>> =
            columns.iter().map(|s| forward(&self.root, &self.told_by(s)[..p])).collect();
        let variance = |k: usize| sds[k] * sds[k];
        Causes {
            mean: (0..n).map(|k| variance(k) * dot(&columns[k], &self.pulls)).collect(),
            given: Matrix::from_fn(n, n, |k, l| {
                let own = if k == l { variance(k) } else { 0.0 };
                own - variance(k) * dot(&columns[k], &weighed[l]) * variance(l)
            }),
            along: Matrix::from_fn(n, p, |k, i| -variance(k) * slopes[k][i]),
        }
    }

    /// By how much the means of [`Linearised::causes`] move if every datum reads `change` more.
    #[must_use]
    pub fn causes_moved(&self, columns: &[Vec<f64>], sds: &[f64], change: &[f64]) -> Vec<f64> {
        let pulled = self.pulled(change);
        columns.iter().zip(sds).map(|(s, sd)| sd * sd * dot(s, &pulled)).collect()
    }

    /// The same with further errors of the data, normal about zero and of variance one, that move them by
    /// their `columns` and are no part of the covariance: what a search for directions has to allow for.
    ///
    /// With S the columns, P becomes P - P S (1 + S'P S)^-1 S'P, whose last term is one more part of what is
    /// learnt.
    ///
    /// # Errors
    /// [`InferenceError::Dense`] if a matrix cannot be decomposed.
    pub fn with_shared(&self, columns: &[Vec<f64>]) -> Result<Self, InferenceError> {
        if columns.is_empty() {
            return Ok(self.clone());
        }
        let (n, p, c) = (self.learnt.rows(), self.learnt.columns(), columns.len());
        let pulled: Vec<Vec<f64>> = columns.iter().map(|s| self.pulled(s)).collect();
        let own = Matrix::from_fn(c, c, |k, l| dot(&columns[k], &pulled[l]) + f64::from(u8::from(k == l)));
        let factor = Cholesky::new(&own)?;
        let told: Vec<f64> = columns.iter().map(|s| dot(s, &self.pulls)).collect();
        let taken = factor.solve(&told);
        let mut found = self.clone();
        found.learnt = Matrix::zeros(n, p + c);
        for i in 0..n {
            let here: Vec<f64> = pulled.iter().map(|v| v[i]).collect();
            found.pulls[i] -= dot(&here, &taken);
            let further = factor.whiten(&here);
            for (j, v) in self.learnt.row(i).iter().chain(&further).enumerate() {
                found.learnt[(i, j)] = *v;
            }
        }
        found.root = Matrix::from_fn(p + c, p, |i, j| if i < p { self.root[(i, j)] } else { 0.0 });
        found.settled()
    }
}
