//! The noise of binned readings, and the transform that makes it white.

use super::{Ambient, Record};
use crate::Pipe;
use rijke_numerics::{Cholesky, Matrix};

/// Readings of bin k have independent noise D and the error e_k of the smoothed ambient temperature, which moves all
/// sensors along b and is correlated from bin to bin: covariance delta_kl D + S_kl b b'.
///
/// Divided by sqrt(D), and turned so that the first of the new readings lies along b/sqrt(D), only that first reading is
/// correlated from bin to bin: its covariance is I + |b|^2 S.
#[derive(Clone, Debug)]
pub(crate) struct Whitening {
    /// Sd of the mean of a full bin, per sensor.
    sd: Vec<f64>,
    /// Ratio of a bin's sd to that of a full bin.
    scale: Vec<f64>,
    /// Householder vector of the turn: the turned reading is r - 2 v (v'r).
    mirror: Vec<f64>,
    along: Option<Cholesky>,
}

impl Whitening {
    pub(crate) fn new(pipe: &Pipe, record: &Record, ambient: &Ambient, bin: usize) -> Self {
        let n = record.samples.len();
        let sizes: Vec<f64> = record.samples.chunks(bin).map(|c| c.len() as f64).collect();
        let full = bin.min(n).max(1) as f64;
        let sd: Vec<f64> = record.sensors.iter().map(|s| s.sd / full.sqrt()).collect();
        let scale: Vec<f64> = sizes.iter().map(|size| (full / size).sqrt()).collect();
        let middle = ambient.temperature.iter().sum::<f64>() / n.max(1) as f64;
        let pull: Vec<f64> =
            record.sensors.iter().zip(&sd).map(|(s, sd)| s.by_ambient(pipe, middle) / sd).collect();
        let length = pull.iter().map(|p| p * p).sum::<f64>().sqrt();
        // The mirror that turns b into the first axis.
        let mut mirror: Vec<f64> = pull.iter().map(|p| p / length).collect();
        let sign = if mirror.first().is_some_and(|m| *m < 0.0) { -1.0 } else { 1.0 };
        if let Some(first) = mirror.first_mut() {
            *first += sign;
        }
        let norm = mirror.iter().map(|m| m * m).sum::<f64>().sqrt();
        mirror.iter_mut().for_each(|m| *m /= norm);
        let drift = ambient.covariance_of_means(bin);
        let covariance = Matrix::from_fn(scale.len(), scale.len(), |k, l| {
            f64::from(u8::from(k == l)) + length * length * drift[(k, l)] / (scale[k] * scale[l])
        });
        // Positive definite by construction: the identity plus a covariance.
        Self { sd, scale, mirror, along: Cholesky::new(&covariance).ok() }
    }

    /// `values`, one bin after the other, with unit covariance of their noise.
    pub(crate) fn apply(&self, mut values: Vec<f64>) -> Vec<f64> {
        let sensors = self.sd.len();
        for (bin, scale) in values.chunks_mut(sensors).zip(&self.scale) {
            bin.iter_mut().zip(&self.sd).for_each(|(v, sd)| *v /= sd * scale);
            let along: f64 = bin.iter().zip(&self.mirror).map(|(v, m)| v * m).sum();
            bin.iter_mut().zip(&self.mirror).for_each(|(v, m)| *v -= 2.0 * along * m);
        }
        if let Some(factor) = &self.along {
            let first: Vec<f64> = values.iter().step_by(sensors).copied().collect();
            let white = factor.whiten(&first);
            values.iter_mut().step_by(sensors).zip(white).for_each(|(v, w)| *v = w);
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Closures;
    use crate::assimilate::{Sample, Sensor, SensorKind, smooth_ambient};
    use rijke_rig::Rig;

    #[test]
    fn oracle_whitens_the_dense_covariance() {
        let pipe = Pipe::new(&Rig::juniper_yoko_2022(), &Closures::default(), 0.25, 1).unwrap();
        let sensor = |microphone| Sensor {
            kind: SensorKind::Arrival { microphone },
            sd: 1e-6 * (1.0 + microphone as f64),
            bias_sd: 0.0,
        };
        let sensors: Vec<Sensor> = (0..3).map(sensor).collect();
        let sample =
            |k: usize| Sample { power: 0.0, ambient: 293.0 + 0.01 * k as f64, readings: vec![0.0; 3] };
        let record = Record {
            interval: 15.0,
            sensors,
            ambient_sd: 0.1,
            ambient_drift: 0.01,
            power_sd: 0.0,
            samples: (0..11).map(sample).collect(),
        };
        let ambient = smooth_ambient(&record);
        let whitening = Whitening::new(&pipe, &record, &ambient, 4);
        let drift = ambient.covariance_of_means(4);
        let middle = ambient.temperature.iter().sum::<f64>() / 11.0;
        let by: Vec<f64> = record.sensors.iter().map(|s| s.by_ambient(&pipe, middle)).collect();
        let sizes = [4.0, 4.0, 3.0];
        let dense = Matrix::from_fn(9, 9, |a, b| {
            let (k, i, l, j) = (a / 3, a % 3, b / 3, b % 3);
            let own = if a == b { record.sensors[i].sd.powi(2) / sizes[k] } else { 0.0 };
            own + drift[(k, l)] * by[i] * by[j]
        });
        // W C W' must be the identity.
        let columns: Vec<Vec<f64>> =
            (0..9).map(|j| whitening.apply((0..9).map(|i| f64::from(u8::from(i == j))).collect())).collect();
        let w = Matrix::from_fn(9, 9, |i, j| columns[j][i]);
        let unit = w.product(&dense).product(&w.transpose());
        for i in 0..9 {
            for j in 0..9 {
                let expected = f64::from(u8::from(i == j));
                assert!((unit[(i, j)] - expected).abs() < 1e-10, "{i} {j}: {}", unit[(i, j)]);
            }
        }
    }
}
