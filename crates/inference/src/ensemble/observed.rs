//! Data, what every member says of them, and both in units in which the noise is the identity.

use super::EnsembleError;
use super::moments::centred;
use rijke_numerics::{Cholesky, Matrix};

/// Covariance of the measurement noise.
#[derive(Clone, Debug, PartialEq)]
pub enum NoiseCovariance {
    /// Independent: the variances.
    Independent(Vec<f64>),
    /// The full covariance.
    Full(Matrix),
}

/// Data and what every member says of them.
#[derive(Clone, Copy, Debug)]
pub struct EnsembleData<'a> {
    /// Members by observations.
    pub predicted: &'a Matrix,
    /// The data.
    pub measured: &'a [f64],
    /// Their noise.
    pub noise: &'a NoiseCovariance,
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
    pub(super) fn new(members: usize, observed: &EnsembleData<'_>) -> Result<Self, EnsembleError> {
        let data = observed.measured.len();
        let shape = |what, expected, got| {
            if expected == got { Ok(()) } else { Err(EnsembleError::Shape { what, expected, got }) }
        };
        shape("rows of the predictions (one per member)", members, observed.predicted.rows())?;
        shape("columns of the predictions (one per datum)", data, observed.predicted.columns())?;
        if let Some(i) = observed.predicted.as_slice().iter().position(|v| !v.is_finite()) {
            return Err(EnsembleError::NotFinite { member: i / data, variable: i % data });
        }
        if let Some(datum) = observed.measured.iter().position(|y| !y.is_finite()) {
            return Err(EnsembleError::Datum { datum });
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
}

/// R^{-1/2} as an operation.
enum Whitener {
    Scale(Vec<f64>),
    Solve(Cholesky),
}

impl Whitener {
    fn new(noise: &NoiseCovariance, data: usize) -> Result<Self, EnsembleError> {
        let shape = |what, got| {
            if data == got { Ok(()) } else { Err(EnsembleError::Shape { what, expected: data, got }) }
        };
        match noise {
            NoiseCovariance::Independent(variances) => {
                shape("variances of the noise", variances.len())?;
                if let Some(pivot) = variances.iter().position(|v| v.is_nan() || *v <= 0.0) {
                    return Err(rijke_numerics::DenseError::NotPositiveDefinite { size: data, pivot }.into());
                }
                Ok(Self::Scale(variances.iter().map(|v| v.sqrt()).collect()))
            }
            NoiseCovariance::Full(covariance) => {
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
