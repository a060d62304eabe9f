//! One analysis: pulling an ensemble towards data.

use super::{Ensemble, EnsembleError, centred, forcing, localise};
use rijke_numerics::{Cholesky, Matrix, Stream, symmetric_eigen};

/// How the members move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// Perturbed observations (Burgers, van Leeuwen & Evensen 1998): each member is pulled towards data with its own
    /// noise. The noise has zero mean over the members, so the mean moves as Kalman's.
    Stochastic,
    /// The symmetric square root (ETKF; Bishop et al. 2001, Wang, Bishop & Julier 2004): mean and sample covariance
    /// become exactly Kalman's.
    SquareRoot,
    /// The symmetric square root followed by a random rotation of the anomalies that keeps mean and covariance
    /// (Sakov & Oke 2008): it undoes clusters and outliers that the square root preserves.
    RotatedSquareRoot,
}

/// Everything an analysis can be told.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// How the members move.
    pub scheme: Scheme,
    /// Factor on the anomalies after the analysis; 1 for none.
    pub inflation: f64,
    /// Relaxation of the spread of every variable towards its prior spread, 0 (none) to 1 (Whitaker & Hamill 2012).
    pub relaxation: f64,
    /// Factor in [0, 1] on the influence of every observation (column) on every variable (row); none for all ones.
    pub localisation: Option<Matrix>,
}

impl Default for Options {
    fn default() -> Self {
        Self { scheme: Scheme::SquareRoot, inflation: 1.0, relaxation: 0.0, localisation: None }
    }
}

/// Covariance of the measurement noise.
#[derive(Clone, Debug, PartialEq)]
pub enum Noise {
    /// Independent: the variances.
    Independent(Vec<f64>),
    /// The full covariance.
    Full(Matrix),
}

/// Data and what every member says of them.
#[derive(Clone, Copy, Debug)]
pub struct Observed<'a> {
    /// Members by observations.
    pub predicted: &'a Matrix,
    /// The data.
    pub measured: &'a [f64],
    /// Their noise.
    pub noise: &'a Noise,
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
    /// Trace of (HPH' + R)^{-1} HPH': how many data's worth of information the analysis used.
    pub degrees_of_freedom: f64,
}

impl Ensemble {
    /// Moves the members towards the data.
    ///
    /// Exact for a linear observation in the sense of [`Scheme`]; a change of units, of the order of the data, or the
    /// split of independent data into batches changes mean and covariance of a square root only by rounding. Cost
    /// O(N p min(N, p) + N p n) for N members, p data, n variables (without localisation).
    ///
    /// # Errors
    /// [`EnsembleError::Shape`] if the lists do not fit, [`EnsembleError::Dense`] if the noise is not positive definite,
    /// [`EnsembleError::NotFinite`] if a prediction is not finite, [`EnsembleError::CorrelatedNoise`] for a localised
    /// square root with full noise.
    pub fn analyse(
        &mut self,
        observed: &Observed<'_>,
        options: &Options,
        stream: &mut Stream,
    ) -> Result<Innovation, EnsembleError> {
        let white = White::new(self, observed)?;
        let gain = Gain::new(&white.anomalies)?;
        let innovation = white.innovation(&gain, observed);
        let before = self.spread();
        match (&options.localisation, options.scheme) {
            (Some(taper), Scheme::Stochastic) => {
                localise::stochastic(self, &white, observed, taper, stream)?;
            }
            (Some(taper), _) => localise::square_root(self, observed, taper)?,
            (None, Scheme::Stochastic) => {
                let perturbations = forcing::centred_normal(self.size(), observed.measured.len(), stream);
                let pull = Matrix::from_fn(self.size(), observed.measured.len(), |i, j| {
                    white.departure[j] + perturbations[(i, j)] - white.anomalies[(i, j)] * white.root
                });
                let change = gain.move_by(&pull, &self.anomalies());
                self.members = self.members.plus(1.0 / white.root, &change);
            }
            (None, _) => {
                let (mean, anomalies) = centred(&self.members);
                let departure = Matrix::from_fn(1, white.departure.len(), |_, j| white.departure[j]);
                let shift = gain.move_by(&departure, &anomalies);
                let shrunk = gain.shrink(&anomalies);
                self.members = Matrix::from_fn(anomalies.rows(), anomalies.columns(), |i, j| {
                    mean[j] + shift[(0, j)] / white.root + shrunk[(i, j)]
                });
            }
        }
        if options.scheme == Scheme::RotatedSquareRoot {
            let rotation = forcing::mean_preserving_rotation(self.size(), stream);
            let (mean, anomalies) = centred(&self.members);
            let turned = rotation.product(&anomalies);
            self.members = Matrix::from_fn(turned.rows(), turned.columns(), |i, j| mean[j] + turned[(i, j)]);
        }
        self.inflate(options, &before);
        Ok(innovation)
    }

    /// Multiplicative inflation and relaxation to prior spread.
    fn inflate(&mut self, options: &Options, before: &[f64]) {
        if options.inflation == 1.0 && options.relaxation == 0.0 {
            return;
        }
        let after = self.spread();
        let factors: Vec<f64> = (before.iter().zip(&after))
            .map(|(&b, &a)| {
                let relaxed = if a > 0.0 { 1.0 + options.relaxation * (b - a) / a } else { 1.0 };
                options.inflation * relaxed
            })
            .collect();
        let mean = self.mean();
        for row in self.members.as_mut_slice().chunks_mut(mean.len()) {
            for ((v, m), f) in row.iter_mut().zip(&mean).zip(&factors) {
                *v = m + f * (*v - m);
            }
        }
    }
}

/// Predictions and data in units in which the noise is the identity.
pub(super) struct White {
    /// Whitened prediction anomalies over sqrt(N - 1), members by observations: S' of the literature.
    pub(super) anomalies: Matrix,
    /// Whitened data minus mean prediction.
    pub(super) departure: Vec<f64>,
    /// sqrt(N - 1).
    pub(super) root: f64,
}

impl White {
    fn new(ensemble: &Ensemble, observed: &Observed<'_>) -> Result<Self, EnsembleError> {
        let (members, data) = (ensemble.size(), observed.measured.len());
        let shape = |what, expected, got| {
            if expected == got { Ok(()) } else { Err(EnsembleError::Shape { what, expected, got }) }
        };
        shape("rows of the predictions (one per member)", members, observed.predicted.rows())?;
        shape("columns of the predictions (one per datum)", data, observed.predicted.columns())?;
        if let Some(i) = observed.predicted.as_slice().iter().position(|v| !v.is_finite()) {
            return Err(EnsembleError::NotFinite { member: i / data, variable: i % data });
        }
        let (mean, mut anomalies) = centred(observed.predicted);
        let departure: Vec<f64> = observed.measured.iter().zip(&mean).map(|(y, m)| y - m).collect();
        let root = (members as f64 - 1.0).sqrt();
        let whitener = Whitener::new(observed.noise, data)?;
        for row in anomalies.as_mut_slice().chunks_mut(data.max(1)) {
            let white = whitener.apply(row);
            row.iter_mut().zip(white).for_each(|(a, w)| *a = w / root);
        }
        Ok(Self { anomalies, departure: whitener.apply(&departure), root })
    }

    /// Innovation statistics, from the same decomposition as the update.
    fn innovation(&self, gain: &Gain, observed: &Observed<'_>) -> Innovation {
        let data = observed.measured.len();
        let (mean, anomalies) = centred(observed.predicted);
        let noise = |j: usize| match observed.noise {
            Noise::Independent(variances) => variances[j],
            Noise::Full(covariance) => covariance[(j, j)],
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
            degrees_of_freedom: gain.eigenvalues.iter().map(|l| l / (1.0 + l)).sum(),
        }
    }
}

/// R^{-1/2} as an operation.
enum Whitener {
    Scale(Vec<f64>),
    Solve(Cholesky),
}

impl Whitener {
    fn new(noise: &Noise, data: usize) -> Result<Self, EnsembleError> {
        let shape = |what, got| {
            if data == got { Ok(()) } else { Err(EnsembleError::Shape { what, expected: data, got }) }
        };
        match noise {
            Noise::Independent(variances) => {
                shape("variances of the noise", variances.len())?;
                if let Some(pivot) = variances.iter().position(|v| v.is_nan() || *v <= 0.0) {
                    return Err(rijke_numerics::DenseError::NotPositiveDefinite { size: data, pivot }.into());
                }
                Ok(Self::Scale(variances.iter().map(|v| v.sqrt()).collect()))
            }
            Noise::Full(covariance) => {
                shape("rows of the noise covariance", covariance.rows())?;
                Ok(Self::Solve(Cholesky::new(covariance)?))
            }
        }
    }

    fn apply(&self, values: &[f64]) -> Vec<f64> {
        match self {
            Self::Scale(sd) => values.iter().zip(sd).map(|(v, sd)| v / sd).collect(),
            Self::Solve(factor) => factor.whiten(values),
        }
    }
}

/// Spectral form of S'S (members) or S S' (data), whichever is smaller; serves weights and square root alike.
pub(super) struct Gain {
    eigenvalues: Vec<f64>,
    /// Rows: members. Columns: v_k sqrt(lambda_k), the images of the data's eigenvectors, or the v_k themselves.
    right: Matrix,
    /// Observations by k: the data's eigenvectors u_k, or the images S v_k.
    left: Matrix,
    members_smaller: bool,
}

impl Gain {
    /// From S' (members by observations).
    pub(super) fn new(s: &Matrix) -> Result<Self, EnsembleError> {
        let members_smaller = s.rows() < s.columns();
        let transposed = s.transpose();
        if members_smaller {
            let (values, right) = symmetric_eigen(&s.product(&transposed))?;
            let left = transposed.product(&right);
            Ok(Self { eigenvalues: clip(values), right, left, members_smaller })
        } else {
            let (values, left) = symmetric_eigen(&transposed.product(s))?;
            let right = s.product(&left);
            Ok(Self { eigenvalues: clip(values), right, left, members_smaller })
        }
    }

    /// For every row r of `pulls` (whitened) the combination r' S (I + S'S)^{-1} of the rows of `anomalies`. Both
    /// spectral forms read the same: the weights over the members are left' r / (1 + lambda) seen through `right`.
    pub(super) fn move_by(&self, pulls: &Matrix, anomalies: &Matrix) -> Matrix {
        let mut coordinates = pulls.product(&self.left);
        for row in coordinates.as_mut_slice().chunks_mut(self.eigenvalues.len().max(1)) {
            row.iter_mut().zip(&self.eigenvalues).for_each(|(c, l)| *c /= 1.0 + l);
        }
        coordinates.product(&self.right.transpose().product(anomalies))
    }

    /// (I + S'S)^{-1/2} times the anomalies. Written as I + right diag(f) right', with
    /// f = ((1 + lambda)^{-1/2} - 1)/lambda for images of the data's eigenvectors, free of cancellation.
    fn shrink(&self, anomalies: &Matrix) -> Matrix {
        let mut coordinates = self.right.transpose().product(anomalies);
        for (k, &l) in self.eigenvalues.iter().enumerate() {
            let root = (1.0 + l).sqrt();
            let over_lambda = -1.0 / (root * (1.0 + root));
            let factor = if self.members_smaller { l * over_lambda } else { over_lambda };
            let columns = coordinates.columns();
            coordinates.as_mut_slice()[k * columns..(k + 1) * columns].iter_mut().for_each(|c| *c *= factor);
        }
        anomalies.plus(1.0, &self.right.product(&coordinates))
    }
}

/// Rounding can leave eigenvalues of a semidefinite matrix just below zero.
fn clip(values: Vec<f64>) -> Vec<f64> {
    values.into_iter().map(|v| v.max(0.0)).collect()
}
