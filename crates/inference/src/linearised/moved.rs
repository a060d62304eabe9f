//! The same fit with other data, to first order: posterior and evidence without another search.

use super::Linearised;
use rijke_numerics::dot;

/// What other data would change, with noise as fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct Moved {
    /// Step of the most probable parameters, in working coordinates; their covariance stays.
    pub step: Vec<f64>,
    /// Change of ln evidence, nats.
    pub ln_evidence: f64,
}

impl Linearised {
    /// What changes if every datum reads `change` more. With d the change, the parameters move by Sigma F'
    /// C^-1 d, and -ln evidence, half the square of the residual from the mean of the prior in the metric P,
    /// grows by (C^-1 r)'d + d'P d/2. Exact for a linear model.
    ///
    /// # Panics
    /// Unless `change` has a number for each datum.
    #[must_use]
    pub fn moved(&self, change: &[f64]) -> Moved {
        let told = self.told_by(change);
        Moved {
            step: self.root.transpose().times(&told),
            ln_evidence: -dot(&self.pulls, change) - 0.5 * dot(change, &self.pulled(change)),
        }
    }

    /// What every datum is predicted to read more after a step of the parameters in working coordinates, F d.
    ///
    /// # Panics
    /// Unless `step` has a number for each parameter.
    #[must_use]
    pub fn predicts(&self, step: &[f64]) -> Vec<f64> {
        // F S = C (C^-1 F S), and S x = d by substitution: S' is lower triangular.
        let p = step.len();
        let mut x = step.to_vec();
        for i in (0..p).rev() {
            let known: f64 = (i + 1..p).map(|j| self.root[(j, i)] * x[j]).sum();
            x[i] = (x[i] - known) / self.root[(i, i)];
        }
        self.with_covariance(&self.learnt.times(&x))
    }

    /// The square of a change of the data in standard deviations of their noise as fitted, d' C^-1 d.
    #[must_use]
    pub fn size_of(&self, change: &[f64]) -> f64 {
        dot(change, &self.weighed(change))
    }

    /// The change of ln evidence in [`Linearised::moved`] with floating noise chosen again, nats: larger
    /// residuals make it larger, which costs less than they do under noise as fitted.
    #[must_use]
    pub fn moved_with_noise(&self, change: &[f64]) -> f64 {
        let after: Vec<f64> = self.pulls.iter().zip(self.pulled(change)).map(|(r, d)| r + d).collect();
        self.moved(change).ln_evidence + self.noise_gains(&after) - self.noise_gains(&self.pulls)
    }
}
