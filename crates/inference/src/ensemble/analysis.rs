//! One analysis: pulling an ensemble towards data.

use super::gain::Gain;
use super::moments::centred;
use super::observed::White;
use super::{Ensemble, EnsembleData, EnsembleError, NoiseCovariance, forcing, localise};
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

/// Everything an analysis can be told.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// How the members move.
    pub scheme: Scheme,
    /// Factor on the anomalies after the analysis; 1 for none.
    pub inflation: f64,
    /// Relaxation of the spread of every variable towards its prior spread, 0 (none) to 1 (Whitaker & Hamill
    /// 2012).
    pub relaxation: f64,
    /// Factor in [0, 1] on the influence of every observation (column) on every variable (row); none for all
    /// ones.
    pub localisation: Option<Matrix>,
}

impl Default for Options {
    fn default() -> Self {
        Self { scheme: Scheme::SquareRoot, inflation: 1.0, relaxation: 0.0, localisation: None }
    }
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
    /// Exact for a linear observation in the sense of [`Scheme`]; a change of units, of the order of the
    /// data, or the split of independent data into batches changes mean and covariance of a square root only
    /// by rounding. Cost O(N p min(N, p) + N p n) for N members, p data, n variables (without localisation).
    ///
    /// # Errors
    /// [`EnsembleError::Shape`] if the lists do not fit, [`EnsembleError::Dense`] if the noise is not
    /// positive definite, [`EnsembleError::NotFinite`] if a prediction is not finite,
    /// [`EnsembleError::CorrelatedNoise`] for a localised square root with full noise.
    pub fn analyse(
        &mut self,
        observed: &EnsembleData<'_>,
        options: &Options,
        stream: &mut Stream,
    ) -> Result<Innovation, EnsembleError> {
        let white = White::new(self.size(), observed)?;
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
            (None, _) => self.members = gain.square_root(&self.members, &white),
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
            degrees_of_freedom: gain.eigenvalues.iter().map(|l| l / (1.0 + l)).sum(),
        }
    }
}
