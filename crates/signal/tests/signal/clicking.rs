//! Synthetic clicks: one band-limited impulse that travels along a tube, is reflected at its far end and
//! again at its near end, recorded by channels with delays and gains.

use rand_distr::{Distribution, StandardNormal};
use rijke_numerics::{Cholesky, Matrix, Streams};

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

    /// Lag of the reflection behind the direct impulse: the tube is 1 m long, with an end correction of 14.5
    /// mm.
    pub(crate) fn gaps(&self) -> Vec<f64> {
        self.positions.iter().map(|x| 2.0 * (1.0145 - x) / self.sound_speed).collect()
    }

    pub(crate) fn arrivals(&self) -> Vec<f64> {
        self.positions.iter().zip(&self.delays).map(|(x, d)| x / self.sound_speed + d).collect()
    }

    pub(crate) fn record(&self, seed: u64, name: &str) -> Vec<Vec<f64>> {
        self.noisy(&self.clean(), seed, name)
    }

    /// What the channels hear, without noise and hum.
    pub(crate) fn clean(&self) -> Vec<Vec<f64>> {
        let gaps = self.gaps();
        // The impulse leaves the loudspeaker 1 ms after the trigger.
        let round_trip = 2.0 * 1.029 / self.sound_speed;
        let heard = |m: usize, arrival: f64, n: usize| {
            let t = (n as f64 - self.quiet as f64) / self.rate_hz;
            let mut y = 0.0;
            for trip in 0..3 {
                let late = t - 1e-3 - arrival - f64::from(trip) * round_trip;
                let size = (self.reflection * self.reflection).powi(trip);
                y += size * (wavelet(late) + self.reflected(late - gaps[m], &wavelet));
            }
            self.gains[m] * self.ratio * y
        };
        let arrivals = self.arrivals();
        (0..8).map(|m| (0..self.length).map(|n| heard(m, arrivals[m], n)).collect()).collect()
    }

    /// The reflection of an impulse `shape` at the far end, which reflects high frequencies less: it comes
    /// back smoothed.
    fn reflected(&self, late: f64, shape: &dyn Fn(f64) -> f64) -> f64 {
        let weight = -self.reflection / 9.0;
        (-4..=4).map(|j| weight * shape(late - 1.2e-5 * f64::from(j))).sum()
    }

    /// `clean` with noise and hum.
    pub(crate) fn noisy(&self, clean: &[Vec<f64>], seed: u64, name: &str) -> Vec<Vec<f64>> {
        let mut stream = Streams::new(seed).stream(name);
        let noisy = |(m, clean): (usize, &Vec<f64>)| {
            let mut y: Vec<f64> = clean.clone();
            for (n, y) in y.iter_mut().enumerate() {
                let noise: f64 = StandardNormal.sample(&mut stream);
                *y += noise;
                if self.hum != 0.0 {
                    let t = (n as f64 - self.quiet as f64) / self.rate_hz;
                    *y += self.hum * (std::f64::consts::TAU * 50.02 * t + m as f64).cos();
                }
            }
            y
        };
        clean.iter().enumerate().map(noisy).collect()
    }

    /// As [`Self::bound`], with the reflection of unknown shape in the window from 0.8 ms before to 0.8 ms
    /// after the impulse, where it overlaps (channels 6 and 7), or the window that ends before it; a parabola
    /// in every channel. The unknowns are times, gains, 13 samples of a waveform of less than 5 kHz, and five
    /// taps of the reflection that are known beforehand to `tolerance`: the Fisher matrix with every column
    /// written out at the truth.
    pub(crate) fn bound_with_reflection(&self, pivot: usize, tolerance: f64) -> Matrix {
        let (half, gaps) = (0.8e-3, self.gaps());
        let (taps, coefficients) = (5, 13);
        let size = 16 + taps + coefficients + 24;
        let mut fisher = Matrix::zeros(size, size);
        let slope = |t: f64| (wavelet(t + 1e-7) - wavelet(t - 1e-7)) / 2e-7;
        for m in 0..8 {
            let overlaps = gaps[m] - half < 0.4 * half;
            let end = if overlaps { half } else { half.min(gaps[m] - half) };
            let gain = self.gains[m] * self.ratio;
            let samples = ((half + end) * self.rate_hz) as i32;
            for n in 0..samples {
                let t = f64::from(n) / self.rate_hz - half;
                let both = |shape: &dyn Fn(f64) -> f64| {
                    shape(t) + if overlaps { self.reflected(t - gaps[m], shape) } else { 0.0 }
                };
                let mut row = vec![0.0; size];
                row[m] = -gain * both(&slope);
                row[8 + m] = both(&wavelet);
                for j in (0..taps).filter(|_| overlaps) {
                    row[16 + j] = gain * wavelet(t - gaps[m] - 6e-5 * (j as f64 - 2.0));
                }
                for k in 0..coefficients {
                    let centre = 1e-4 * (k as f64 - 6.0);
                    let sinc = |t: f64| {
                        let u = std::f64::consts::PI * (t - centre) / 1e-4;
                        if u == 0.0 { 1.0 } else { u.sin() / u }
                    };
                    row[16 + taps + k] = gain * both(&sinc);
                }
                for power in 0..3 {
                    row[16 + taps + coefficients + 3 * m + power] = (t / half).powi(power as i32);
                }
                for i in 0..size {
                    for j in (0..size).filter(|_| row[i] != 0.0) {
                        fisher[(i, j)] += row[i] * row[j];
                    }
                }
            }
        }
        for j in 0..taps {
            fisher[(16 + j, 16 + j)] += (tolerance * self.reflection).powi(-2);
        }
        // Time and gain of the pivot are absorbed by the waveform.
        let free: Vec<usize> = (0..size).filter(|&i| i != pivot && i != 8 + pivot).collect();
        let scale: Vec<f64> = free.iter().map(|&i| fisher[(i, i)].sqrt().recip()).collect();
        let scaled =
            Matrix::from_fn(free.len(), free.len(), |i, j| fisher[(free[i], free[j])] * scale[i] * scale[j]);
        let inverse = Cholesky::new(&scaled).unwrap().inverse();
        let place = |m: usize| free.iter().position(|&i| i == m);
        Matrix::from_fn(8, 8, |i, j| match (place(i), place(j)) {
            (Some(a), Some(b)) => inverse[(a, b)] * scale[a] * scale[b],
            _ => 0.0,
        })
    }

    /// Covariance bound of the arrival times for an unknown common waveform of bandwidth below half the
    /// sampling rate, gains unknown, noise of unit variance, direct impulse alone; relative to channel
    /// `pivot`.
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
