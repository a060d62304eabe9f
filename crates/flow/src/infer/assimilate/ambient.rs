//! The ambient temperature from a noisy thermometer.

use super::record::FlowRecord;
use rijke_numerics::Matrix;

/// The smoothed ambient temperature, and the error that is left.
#[derive(Clone, Debug)]
pub struct Ambient {
    /// At every sample, K.
    pub temperature: Vec<f64>,
    /// Precision of the path: diagonal and the constant beside it, 1/K^2.
    diagonal: Vec<f64>,
    beside: f64,
}

/// Smoothed ambient temperature at every sample.
///
/// The path is a random walk (drift) seen with white noise, so its posterior precision is tridiagonal:
/// 1/noise on the diagonal plus the second difference over the walk's variance per step. The constant error
/// of the thermometer is one of the unknowns and not part of this.
#[must_use]
pub fn smooth_ambient(record: &FlowRecord) -> Ambient {
    let noise = record.ambient_sd.powi(2).max(1e-12);
    let walk = (record.ambient_drift.powi(2) * record.interval).max(1e-12);
    let n = record.samples.len();
    let neighbours = |i: usize| f64::from(u8::from(i > 0)) + f64::from(u8::from(i + 1 < n));
    let diagonal = (0..n).map(|i| 1.0 / noise + neighbours(i) / walk).collect();
    let mut ambient = Ambient { temperature: Vec::new(), diagonal, beside: -1.0 / walk };
    // From the first reading, so that nothing is lost to rounding.
    let first = record.samples.first().map_or(0.0, |s| s.ambient);
    let mut path: Vec<f64> = record.samples.iter().map(|s| (s.ambient - first) / noise).collect();
    ambient.solve(&mut path);
    ambient.temperature = path.into_iter().map(|t| first + t).collect();
    ambient
}

impl Ambient {
    /// Covariance of the error at the first sample and of the means over `bin` samples each, K^2.
    #[must_use]
    pub fn covariance(&self, bin: usize) -> Matrix {
        let n = self.temperature.len();
        let means = (0..n).step_by(bin).map(|k| k..(k + bin).min(n));
        let bins: Vec<std::ops::Range<usize>> = std::iter::once(0..n.min(1)).chain(means).collect();
        let columns: Vec<Vec<f64>> = bins
            .iter()
            .map(|range| {
                let mut mean = vec![0.0; n];
                mean[range.clone()].fill(1.0 / range.len() as f64);
                self.solve(&mut mean);
                mean
            })
            .collect();
        Matrix::from_fn(bins.len(), bins.len(), |i, j| {
            columns[j][bins[i].clone()].iter().sum::<f64>() / bins[i].len() as f64
        })
    }

    /// Solves with the precision, in place.
    fn solve(&self, x: &mut [f64]) {
        let n = x.len();
        let mut pivots = self.diagonal.clone();
        for i in 1..n {
            let factor = self.beside / pivots[i - 1];
            pivots[i] -= factor * self.beside;
            x[i] -= factor * x[i - 1];
        }
        for i in (0..n).rev() {
            let above = if i + 1 < n { self.beside * x[i + 1] } else { 0.0 };
            x[i] = (x[i] - above) / pivots[i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::infer::assimilate::record::Sample;
    use rijke_numerics::Cholesky;

    fn record(readings: &[f64]) -> FlowRecord {
        let sample = |&ambient: &f64| Sample { power: 0.0, ambient, readings: Vec::new() };
        FlowRecord {
            interval: 15.0,
            sensors: Vec::new(),
            ambient_sd: 0.1,
            ambient_drift: 0.01,
            power_sd: 0.0,
            samples: readings.iter().map(sample).collect(),
        }
    }

    #[test]
    fn oracle_dense_conditioning_of_a_random_walk() {
        let readings = [293.1, 293.3, 293.2, 293.0, 293.15, 293.4, 293.35];
        let record = record(&readings);
        let (noise, walk, n) = (0.01, 0.01 * 0.01 * 15.0, readings.len());
        // A walk from a start known to 10 K, conditioned by the textbook formula C - C (C + R)^-1 C.
        let prior = Matrix::from_fn(n, n, |i, j| 100.0 + walk * i.min(j) as f64);
        let with_noise = Cholesky::new(&prior.plus(noise, &Matrix::identity(n))).unwrap();
        let residual: Vec<f64> = readings.iter().map(|r| r - 293.0).collect();
        let mean = prior.times(&with_noise.solve(&residual));
        let posterior = prior.plus(-1.0, &prior.product(&with_noise.inverse()).product(&prior));
        let ambient = smooth_ambient(&record);
        for i in 0..n {
            assert!((ambient.temperature[i] - 293.0 - mean[i]).abs() < 1e-5);
        }
        let bins = ambient.covariance(3);
        for (i, a) in [0..1, 0..3, 3..6, 6..7].into_iter().enumerate() {
            for (j, b) in [0..1, 0..3, 3..6, 6..7].into_iter().enumerate() {
                let pairs = a.clone().flat_map(|k| b.clone().map(move |l| (k, l)));
                let sum: f64 = pairs.map(|(k, l)| posterior[(k, l)]).sum();
                let mean = sum / (a.len() * b.len()) as f64;
                assert!((bins[(i, j)] - mean).abs() < 1e-6, "{} {mean}", bins[(i, j)]);
            }
        }
    }
}
