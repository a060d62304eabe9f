//! One analysis: pulling an ensemble towards data.

use super::gain::Gain;
use super::moments::centred;
use super::observed::White;
use super::{Ensemble, EnsembleData, EnsembleError, NoiseCovariance, forcing};
use rijke_numerics::{Matrix, Stream};

/// How the members move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// Perturbed observations (Burgers, van Leeuwen & Evensen 1998): each member is pulled towards data with
    /// its own noise. The noise has zero mean over the members, so the mean moves as Kalman's.
    Stochastic,
    /// The symmetric square root (ETKF; Bishop et al. 2001, Wang, Bishop & Julier 2004): mean and sample
    /// covariance become exactly Kalman's.
    SquareRoot,
    /// The symmetric square root followed by a random rotation of the anomalies that keeps mean and
    /// covariance (Sakov & Oke 2008): it undoes clusters and outliers that the square root preserves.
    RotatedSquareRoot,
}

/// What an analysis found before it moved the members.
#[derive(Clone, Debug, PartialEq)]
pub struct Innovation {
    /// Data minus mean prediction.
    pub values: Vec<f64>,
    /// Expected sd of each: square root of the diagonal of HPH' + R.
    pub expected: Vec<f64>,
    /// values' (HPH' + R)^{-1} values; its expectation is the number of data if the filter is consistent.
    pub chi_squared: f64,
}

impl Ensemble {
    /// Moves the members towards the data.
    ///
    /// Exact for a linear observation in the sense of [`Scheme`]; a change of units, of the order of the
    /// data, or the split of independent data into batches changes mean and covariance of a square root only
    /// by rounding. Cost O(N p min(N, p) + N p n) for N members, p data, n variables.
    ///
    /// # Errors
    /// [`EnsembleError::Shape`] if the lists do not fit, [`EnsembleError::Dense`] if the noise is not
    /// positive definite, [`EnsembleError::NotFinite`] if a prediction or a member is not finite,
    /// [`EnsembleError::Datum`] if a datum is not.
    pub fn analyse(
        &mut self,
        observed: &EnsembleData<'_>,
        scheme: Scheme,
        stream: &mut Stream,
    ) -> Result<Innovation, EnsembleError> {
        if let Some(k) = self.members.as_slice().iter().position(|v| !v.is_finite()) {
            let columns = self.members.columns();
            return Err(EnsembleError::NotFinite { member: k / columns, variable: k % columns });
        }
        let white = White::new(self.size(), observed)?;
        let gain = Gain::new(&white.anomalies)?;
        let innovation = white.innovation(&gain, observed);
        if scheme == Scheme::Stochastic {
            let perturbations = forcing::centred_normal(self.size(), observed.measured.len(), stream);
            let pull = Matrix::from_fn(self.size(), observed.measured.len(), |i, j| {
                white.departure[j] + perturbations[(i, j)] - white.anomalies[(i, j)] * white.root
            });
            let change = gain.move_by(&pull, &self.anomalies());
            self.members = self.members.plus(1.0 / white.root, &change);
        } else {
            self.members = gain.square_root(&self.members, &white);
        }
        if scheme == Scheme::RotatedSquareRoot {
            let rotation = forcing::mean_preserving_rotation(self.size(), stream);
            let (mean, anomalies) = centred(&self.members);
            let turned = rotation.product(&anomalies);
            self.members = Matrix::from_fn(turned.rows(), turned.columns(), |i, j| mean[j] + turned[(i, j)]);
        }
        Ok(innovation)
    }
}

impl White {
    /// Innovation statistics, from the same decomposition as the update.
    fn innovation(&self, gain: &Gain, observed: &EnsembleData<'_>) -> Innovation {
        let data = observed.measured.len();
        let (mean, anomalies) = centred(observed.predicted);
        let noise = |j: usize| match observed.noise {
            NoiseCovariance::Independent(variances) => variances[j],
            NoiseCovariance::Full(covariance) => covariance[(j, j)],
        };
        let expected = (0..data)
            .map(|j| {
                let spread: f64 =
                    (0..anomalies.rows()).map(|i| (anomalies[(i, j)] / self.root).powi(2)).sum();
                (spread + noise(j)).sqrt()
            })
            .collect();
        // d'(I + S S')^{-1} d = d'd - d'S (I + S'S)^{-1} S'd: the predictions moved like any other variable.
        let departure = Matrix::from_fn(1, data, |_, j| self.departure[j]);
        let moved = gain.move_by(&departure, &self.anomalies);
        let explained: f64 = moved.row(0).iter().zip(&self.departure).map(|(m, d)| m * d).sum();
        Innovation {
            values: observed.measured.iter().zip(&mean).map(|(y, m)| y - m).collect(),
            expected,
            chi_squared: self.departure.iter().map(|d| d * d).sum::<f64>() - explained,
        }
    }
}
