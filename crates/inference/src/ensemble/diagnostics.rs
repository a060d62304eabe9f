//! When not to believe an ensemble.

use super::Innovation;
use crate::numbers::normal_cdf;
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

/// Ranks of truths among members, in equal bins: flat if the ensemble is reliable, a U if it is
/// overconfident.
#[derive(Clone, Debug, PartialEq)]
pub struct RankHistogram {
    /// Counts per bin.
    pub counts: Vec<usize>,
}

impl RankHistogram {
    /// An empty histogram with `bins` bins.
    #[must_use]
    pub fn new(bins: usize) -> Self {
        Self { counts: vec![0; bins] }
    }

    /// Counts one truth by the fraction of the distribution below it, in [0, 1].
    pub fn record(&mut self, fraction: f64) {
        let bins = self.counts.len();
        let bin = ((fraction * bins as f64).max(0.0) as usize).min(bins.saturating_sub(1));
        if let Some(count) = self.counts.get_mut(bin) {
            *count += 1;
        }
    }

    /// Pearson's statistic against a flat histogram; chi-squared with bins - 1 degrees of freedom if flat.
    #[must_use]
    pub fn statistic(&self) -> f64 {
        let total: usize = self.counts.iter().sum();
        let expected = total as f64 / self.counts.len() as f64;
        self.counts.iter().map(|&c| (c as f64 - expected).powi(2) / expected).sum()
    }

    /// Probability that a flat histogram gives a larger statistic (Wilson & Hilferty 1931: the cube root of a
    /// chi-squared over its degrees of freedom is normal to about 0.002 in probability for 5 or more).
    #[must_use]
    pub fn p_value(&self) -> f64 {
        let degrees = self.counts.len() as f64 - 1.0;
        let spread = 2.0 / (9.0 * degrees);
        let z = ((self.statistic() / degrees).cbrt() - (1.0 - spread)) / spread.sqrt();
        1.0 - normal_cdf(z)
    }
}
