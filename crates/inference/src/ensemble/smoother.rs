//! The iterative smoother: one data set assimilated several times with inflated noise.

use super::{Ensemble, EnsembleData, EnsembleError, NoiseCovariance, Scheme};
use rijke_numerics::{Matrix, Streams};

/// How to smooth.
#[derive(Clone, Debug, PartialEq)]
pub struct Smoother {
    /// Factors alpha on the noise covariance, one per pass; their reciprocals sum to 1.
    pub coefficients: Vec<f64>,
}

/// One pass, for diagnosis.
#[derive(Clone, Debug, PartialEq)]
pub struct Pass {
    /// Factor on the noise.
    pub coefficient: f64,
    /// Spread of the variables after the pass.
    pub spread: Vec<f64>,
}

/// What a smoother returns.
#[derive(Clone, Debug, PartialEq)]
pub struct Smoothed {
    /// The final ensemble, with all failures on the way.
    pub ensemble: Ensemble,
    /// One entry per pass.
    pub passes: Vec<Pass>,
}

impl Default for Smoother {
    /// Four passes with falling noise, alpha = 28/3, 7, 4, 2 (Emerick & Reynolds 2013, table 1).
    fn default() -> Self {
        Self { coefficients: vec![28.0 / 3.0, 7.0, 4.0, 2.0] }
    }
}

/// ES-MDA (Emerick & Reynolds 2013, Computers & Geosciences 55, 3-15): every pass runs the model on the whole
/// record and analyses all data with noise covariance alpha R. Exact for a linear model and a Gaussian prior;
/// for a nonlinear one several small steps follow the curvature that one big step would miss.
///
/// A member whose run fails is replaced as in [`Ensemble::forecast`].
///
/// # Errors
/// [`EnsembleError::Coefficients`] unless the reciprocals sum to 1 within 1e-9; else as
/// [`Ensemble::analyse`].
pub fn smooth<E: std::fmt::Display + Send>(
    prior: Ensemble,
    measured: &[f64],
    noise: &NoiseCovariance,
    smoother: &Smoother,
    streams: &Streams,
    model: impl Fn(&[f64]) -> Result<Vec<f64>, E> + Sync,
) -> Result<Smoothed, EnsembleError> {
    let sum: f64 = smoother.coefficients.iter().map(|a| 1.0 / a).sum();
    // A NaN is none of both.
    let sound = (sum - 1.0).abs() <= 1e-9 && smoother.coefficients.iter().all(|a| *a >= 1.0);
    if !sound {
        return Err(EnsembleError::Coefficients { sum });
    }
    let mut ensemble = prior;
    let mut passes = Vec::with_capacity(smoother.coefficients.len());
    for (step, &alpha) in smoother.coefficients.iter().enumerate() {
        let mut stream = streams.stream(&format!("smoother/pass-{step}"));
        let rows = ensemble.forecast(step, &mut stream, |_, row| model(row))?;
        if let Some(row) = rows.iter().find(|row| row.len() != measured.len()) {
            let what = "data that the model predicts";
            return Err(EnsembleError::Shape { what, expected: measured.len(), got: row.len() });
        }
        let predicted = Matrix::from_fn(ensemble.size(), measured.len(), |i, j| rows[i][j]);
        let inflated = match noise {
            NoiseCovariance::Independent(variances) => {
                NoiseCovariance::Independent(variances.iter().map(|v| alpha * v).collect())
            }
            NoiseCovariance::Full(c) => NoiseCovariance::Full(c.plus(alpha - 1.0, c)),
        };
        let observed = EnsembleData { predicted: &predicted, measured, noise: &inflated };
        ensemble.analyse(&observed, Scheme::SquareRoot, &mut stream)?;
        passes.push(Pass { coefficient: alpha, spread: ensemble.spread() });
    }
    Ok(Smoothed { ensemble, passes })
}
