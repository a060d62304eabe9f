//! Synthetic clicks: one band-limited impulse that travels along a tube, is reflected at its far end and again at its
//! near end, recorded by channels with delays and gains.

use rand_distr::{Distribution, StandardNormal};
use rijke_numerics::{Matrix, Streams};

#[derive(Clone, Debug)]
pub(crate) struct Clicking {
    pub(crate) rate_hz: f64,
    pub(crate) quiet: usize,
    pub(crate) length: usize,
    pub(crate) positions: Vec<f64>,
    pub(crate) sound_speed: f64,
    pub(crate) delays: Vec<f64>,
    pub(crate) gains: Vec<f64>,
    /// Peak of the impulse over the standard deviation of the noise.
    pub(crate) ratio: f64,
    /// Strength of the reflection at the far end.
    pub(crate) reflection: f64,
    pub(crate) hum: f64,
}

/// Ricker wavelet at 1.5 kHz: 1 % of its largest amplitude at 4 kHz.
pub(crate) fn wavelet(t: f64) -> f64 {
    let a = (std::f64::consts::PI * 1500.0 * t).powi(2);
    (1.0 - 2.0 * a) * (-a).exp()
}

impl Clicking {
    pub(crate) fn tube(ratio: f64) -> Self {
        Self {
            rate_hz: 62_500.0,
            quiet: 1250,
            length: 6250,
            positions: (0..8).map(|m| 0.25 + 0.1 * f64::from(m)).collect(),
            sound_speed: 343.0,
            delays: vec![0.0; 8],
            gains: vec![1.0; 8],
            ratio,
            reflection: 0.8,
            hum: 0.0,
        }
    }

    /// Lag of the reflection behind the direct impulse: the tube is 1 m long, with an end correction of 14.5 mm.
    pub(crate) fn gaps(&self) -> Vec<f64> {
        self.positions.iter().map(|x| 2.0 * (1.0145 - x) / self.sound_speed).collect()
    }

    pub(crate) fn arrivals(&self) -> Vec<f64> {
        self.positions.iter().zip(&self.delays).map(|(x, d)| x / self.sound_speed + d).collect()
    }

    pub(crate) fn record(&self, seed: u64, name: &str) -> Vec<Vec<f64>> {
        let mut stream = Streams::new(seed).stream(name);
        let gaps = self.gaps();
        // The impulse leaves the loudspeaker 1 ms after the trigger.
        let round_trip = 2.0 * 1.029 / self.sound_speed;
        self.arrivals()
            .iter()
            .enumerate()
            .map(|(m, arrival)| {
                (0..self.length)
                    .map(|n| {
                        let t = (n as f64 - self.quiet as f64) / self.rate_hz;
                        let noise: f64 = StandardNormal.sample(&mut stream);
                        let mut y = 0.0;
                        for trip in 0..3 {
                            let late = t - 1e-3 - arrival - f64::from(trip) * round_trip;
                            let size = (self.reflection * self.reflection).powi(trip);
                            y += size * wavelet(late);
                            // An end that reflects high frequencies less: the impulse comes back smoothed.
                            for j in -4..=4 {
                                let weight = self.reflection / 9.0;
                                y -= size * weight * wavelet(late - gaps[m] - 1.2e-5 * f64::from(j));
                            }
                        }
                        let hum = self.hum * (std::f64::consts::TAU * 50.02 * t + m as f64).cos();
                        self.gains[m] * (self.ratio * y) + noise + hum
                    })
                    .collect()
            })
            .collect()
    }

    /// Covariance bound of the arrival times for an unknown common waveform of bandwidth below half the sampling
    /// rate, gains unknown, noise of unit variance, direct impulse alone; relative to channel `pivot`.
    pub(crate) fn bound(&self, pivot: usize) -> Matrix {
        // Fisher information of a shift for known waveform: sum of squared slopes, per channel.
        let slope: f64 = (-2000..2000)
            .map(|n| {
                let t = f64::from(n) / self.rate_hz / 10.0;
                ((wavelet(t + 1e-7) - wavelet(t - 1e-7)) / 2e-7 * self.ratio).powi(2) / 10.0
            })
            .sum();
        let information: Vec<f64> = self.gains.iter().map(|g| g * g * slope).collect();
        // Eliminating the waveform leaves the differences between channels, each with its own information.
        Matrix::from_fn(8, 8, |i, j| {
            if i == pivot || j == pivot {
                0.0
            } else {
                f64::from(u8::from(i == j)) / information[i] + 1.0 / information[pivot]
            }
        })
    }
}
