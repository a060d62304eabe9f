//! When not to believe an ensemble.

use super::Innovation;
use rijke_numerics::{DenseError, Matrix, symmetric_eigen};

/// Innovations of a whole run, collected one analysis at a time.
///
/// Necessary, not sufficient: a collapsed filter that is confident of wrong parameters can have a perfect
/// chi-squared. Compare the spread with the error in a twin experiment, and with a second method on the real
/// data.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Diagnostics {
    chi_squared: f64,
    data: usize,
    /// Per observation: sum of n_t^2, sum of n_t n_{t-1}, last n_t; n is the innovation over its expected sd.
    series: Vec<[f64; 3]>,
    analyses: usize,
}

impl Diagnostics {
    /// Takes note of one analysis. The observations must be the same kind in the same order each time.
    pub fn record(&mut self, innovation: &Innovation) {
        self.series.resize(innovation.values.len().max(self.series.len()), [0.0; 3]);
        for (series, (v, sd)) in
            self.series.iter_mut().zip(innovation.values.iter().zip(&innovation.expected))
        {
            let n = v / sd;
            *series = [series[0] + n * n, series[1] + n * series[2], n];
        }
        self.chi_squared += innovation.chi_squared;
        self.data += innovation.values.len();
        self.analyses += 1;
    }

    /// Chi-squared per datum; 1 is expected.
    #[must_use]
    pub fn chi_squared_per_datum(&self) -> f64 {
        self.chi_squared / self.data as f64
    }

    /// Correlation of each observation's normalised innovation with its own previous one; 0 is expected, with
    /// sd 1/sqrt(analyses).
    #[must_use]
    pub fn whiteness(&self) -> Vec<f64> {
        self.series.iter().map(|s| s[1] / s[0]).collect()
    }

    /// Number of analyses recorded.
    #[must_use]
    pub fn analyses(&self) -> usize {
        self.analyses
    }
}

/// Effective rank of a covariance, (sum lambda)^2 / sum lambda^2 of its correlation matrix: how many
/// independent directions the members still span. Variables without spread are left out.
///
/// # Errors
/// [`DenseError::NoEigenvalues`] for a NaN.
pub fn effective_rank(covariance: &Matrix) -> Result<f64, DenseError> {
    let live: Vec<usize> = (0..covariance.rows()).filter(|&i| covariance[(i, i)] > 0.0).collect();
    let kept = covariance.select(&live);
    let correlation =
        Matrix::from_fn(live.len(), live.len(), |i, j| kept[(i, j)] / (kept[(i, i)] * kept[(j, j)]).sqrt());
    let (values, _) = symmetric_eigen(&correlation)?;
    let (sum, squares) = values.iter().fold((0.0, 0.0), |(s, q), v| (s + v, q + v * v));
    Ok(if squares > 0.0 { sum * sum / squares } else { 0.0 })
}
