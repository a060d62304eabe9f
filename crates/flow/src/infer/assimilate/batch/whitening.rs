//! The noise of binned readings, and the transform that makes it white.

use crate::error::FlowError;
use crate::infer::assimilate::ambient::Ambient;
use rijke_numerics::{Matrix, symmetric_eigen};

/// Readings have independent noise D and feel the error e of the smoothed ambient temperature: covariance D +
/// G P G' with P the covariance of e at the start and of its means over bins, and G the response of the
/// model.
///
/// The response is that of the whole model: the wall keeps the error of its first temperature for half an
/// hour, in which the clicks without power calibrate the channels, while gas at rest has the wall's
/// temperature and not the room's.
///
/// In units of sqrt(D) the covariance is 1 + U U'. Along an eigenvector of U U' with eigenvalue l the
/// transform divides by sqrt(1 + l); everything else it leaves alone.
#[derive(Clone, Debug)]
pub(crate) struct Whitening {
    /// Sd of every mean reading.
    sd: Vec<f64>,
    /// Unit vectors, and (1 + l)^{-1/2} - 1.
    directions: Vec<(Vec<f64>, f64)>,
}

impl Whitening {
    /// From the sd of every mean reading and the `responses` to the temperature at the start and in each bin,
    /// per K; none for a temperature that is known.
    pub(crate) fn new(
        sd: Vec<f64>,
        responses: &[Vec<f64>],
        ambient: &Ambient,
        bin: usize,
    ) -> Result<Self, FlowError> {
        if responses.is_empty() {
            return Ok(Self { sd, directions: Vec::new() });
        }
        let (values, vectors) = symmetric_eigen(&ambient.covariance(bin))?;
        let size = responses.len();
        // Columns of U = D^{-1/2} G V sqrt(l), with P = V l V'.
        let column = |j: usize| -> Vec<f64> {
            let mut sum = vec![0.0; sd.len()];
            let root = values[j].max(0.0).sqrt();
            for (i, response) in responses.iter().enumerate() {
                let share = root * vectors[(i, j)];
                sum.iter_mut().zip(response).for_each(|(s, r)| *s += share * r);
            }
            sum.iter().zip(&sd).map(|(s, sd)| s / sd).collect()
        };
        let columns: Vec<Vec<f64>> = (0..size).map(column).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let (values, vectors) =
            symmetric_eigen(&Matrix::from_fn(size, size, |i, j| dot(&columns[i], &columns[j])))?;
        let seen = (0..size).filter(|&k| values[k] > SEEN);
        let direction = |k: usize| {
            let mut unit = vec![0.0; sd.len()];
            for (j, column) in columns.iter().enumerate() {
                let share = vectors[(j, k)] / values[k].sqrt();
                unit.iter_mut().zip(column).for_each(|(u, c)| *u += share * c);
            }
            (unit, (1.0 + values[k]).sqrt().recip() - 1.0)
        };
        let directions = seen.map(direction).collect();
        Ok(Self { sd, directions })
    }

    /// `values`, one bin after the other, with unit covariance of their noise.
    pub(crate) fn apply(&self, mut values: Vec<f64>) -> Vec<f64> {
        values.iter_mut().zip(&self.sd).for_each(|(v, sd)| *v /= sd);
        // The directions are orthogonal, so one after the other is all at once.
        for (unit, factor) in &self.directions {
            let along: f64 = unit.iter().zip(&values).map(|(u, v)| u * v).sum();
            values.iter_mut().zip(unit).for_each(|(v, u)| *v += factor * along * u);
        }
        values
    }
}

/// Excess variance along a direction that is worth a turn.
const SEEN: f64 = 1e-4;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::infer::assimilate::ambient::smooth_ambient;
    use crate::infer::assimilate::record::{FlowRecord, Sample};

    #[test]
    fn oracle_whitens_the_dense_covariance() {
        let sample = |k: usize| Sample { power: 0.0, ambient: 293.0 + 0.01 * k as f64, readings: Vec::new() };
        let record = FlowRecord {
            interval: 15.0,
            sensors: Vec::new(),
            ambient_sd: 0.1,
            ambient_drift: 0.01,
            power_sd: 0.0,
            samples: (0..11).map(sample).collect(),
        };
        let ambient = smooth_ambient(&record);
        let sd: Vec<f64> = (0..9).map(|k| 1.0 + 0.1 * f64::from(k)).collect();
        let responses: Vec<Vec<f64>> =
            (0..4).map(|i| (0..9).map(|k| 30.0 * f64::from(1 + k * i % 7)).collect()).collect();
        let whitening = Whitening::new(sd.clone(), &responses, &ambient, 4).unwrap();
        let p = ambient.covariance(4);
        let dense = Matrix::from_fn(9, 9, |a, b| {
            let own = if a == b { sd[a].powi(2) } else { 0.0 };
            let pairs = (0..4).flat_map(|i| (0..4).map(move |j| (i, j)));
            own + pairs.map(|(i, j)| responses[i][a] * p[(i, j)] * responses[j][b]).sum::<f64>()
        });
        // W C W' must be the identity.
        let columns: Vec<Vec<f64>> =
            (0..9).map(|j| whitening.apply((0..9).map(|i| f64::from(u8::from(i == j))).collect())).collect();
        let w = Matrix::from_fn(9, 9, |i, j| columns[j][i]);
        let unit = w.product(&dense).product(&w.transpose());
        for i in 0..9 {
            for j in 0..9 {
                let expected = f64::from(u8::from(i == j));
                assert!((unit[(i, j)] - expected).abs() < 1e-3, "{i} {j}: {}", unit[(i, j)]);
            }
        }
    }
}
