//! Synthetic pings: quiet part, steady forcing, free decay of several modes, noise of a given colour, hum.

use rand_distr::{Distribution, StandardNormal};
use rijke_numerics::{C64, Cholesky, Matrix, Streams};

/// Everything that makes one ping record.
#[derive(Clone, Debug)]
pub(crate) struct Ringing {
    pub(crate) rate_hz: f64,
    pub(crate) quiet: usize,
    pub(crate) forced: usize,
    pub(crate) decay: usize,
    /// Modes and their complex amplitudes per channel at the end of forcing.
    pub(crate) modes: Vec<(C64, Vec<C64>)>,
    pub(crate) forcing: f64,
    /// Standard deviation of the white part of the noise, per channel.
    pub(crate) noise: f64,
    /// First-order colour: noise_n = colour noise_{n-1} + white.
    pub(crate) colour: f64,
    /// Amplitudes of 50, 100, 150 Hz hum.
    pub(crate) hum: f64,
    /// Harmonics go with the true frequency of the mains, Hz.
    pub(crate) mains_hz: f64,
}

impl Ringing {
    /// A tube's fundamental and octave at eight microphones; amplitude over noise `ratio` at the strongest
    /// one.
    pub(crate) fn tube(growth_rate: f64, ratio: f64) -> Self {
        let shape = |k: f64, x: f64| C64::new((std::f64::consts::PI * k * x).sin(), 0.03 * x);
        let positions: Vec<f64> = (0..8).map(|m| 0.25 + 0.1 * f64::from(m)).collect();
        let amplitudes = |k: f64, a: f64| positions.iter().map(|&x| a * shape(k, x)).collect();
        Self {
            rate_hz: 1e4,
            quiet: 2000,
            forced: 2000,
            decay: 11_000,
            modes: vec![
                (C64::new(growth_rate, 1090.0), amplitudes(1.0, ratio)),
                (C64::new(1.8 * growth_rate, 2185.0), amplitudes(2.0, 0.2 * ratio)),
            ],
            forcing: 1097.0,
            noise: 1.0,
            colour: 0.0,
            hum: 0.0,
            mains_hz: 50.02,
        }
    }

    /// One record; `name` selects the noise and the phase of the forcing.
    pub(crate) fn record(&self, seed: u64, name: &str) -> Vec<Vec<f64>> {
        use rand::RngExt;
        let mut stream = Streams::new(seed).stream(name);
        let phase: f64 = stream.random::<f64>() * std::f64::consts::TAU;
        let channels = self.modes[0].1.len();
        let total = self.quiet + self.forced + self.decay;
        let end = self.quiet + self.forced;
        (0..channels)
            .map(|m| {
                let hum_phase: f64 = stream.random::<f64>() * std::f64::consts::TAU;
                let mut previous = 0.0;
                let mut y: Vec<f64> = (0..total)
                    .map(|_| {
                        let white: f64 = StandardNormal.sample(&mut stream);
                        previous = self.colour * previous + self.noise * white;
                        previous
                    })
                    .collect();
                let time = |n: usize| (n as f64 - end as f64) / self.rate_hz;
                for h in (1..=3).filter(|_| self.hum != 0.0) {
                    for (n, y) in y.iter_mut().enumerate() {
                        let angle = std::f64::consts::TAU * self.mains_hz * f64::from(h) * time(n);
                        *y += self.hum / f64::from(h) * (angle + hum_phase * f64::from(h)).cos();
                    }
                }
                for (s, amplitudes) in &self.modes {
                    let forcing = C64::new(0.0, self.forcing);
                    for (exponent, from, to) in [(forcing, self.quiet, end), (*s, end, total)] {
                        let start = exponent * time(from) + C64::new(0.0, phase);
                        let (mut ring, turn) = (amplitudes[m] * start.exp(), (exponent / self.rate_hz).exp());
                        for y in &mut y[from..to] {
                            *y += ring.re;
                            ring *= turn;
                        }
                    }
                }
                y
            })
            .collect()
    }

    /// Covariance bound (Cramer-Rao) of growth rate and frequency of the first mode for white noise and the
    /// decay alone, all modes unknown, amplitudes unknown: the Fisher matrix with every column written out.
    pub(crate) fn bound(&self, harmonics: u32) -> Matrix {
        let channels = self.modes[0].1.len();
        let frequencies = 2 * self.modes.len() + usize::from(harmonics > 0);
        let per_channel = 2 * self.modes.len() + 2 * harmonics as usize;
        let size = frequencies + channels * per_channel;
        let mut fisher = Matrix::zeros(size, size);
        for m in 0..channels {
            for n in 0..self.decay {
                let t = n as f64 / self.rate_hz;
                let mut row: Vec<(usize, f64)> = Vec::new();
                let base = frequencies + m * per_channel;
                for (k, (s, a)) in self.modes.iter().enumerate() {
                    let e = (s * t).exp();
                    row.push((2 * k, t * (a[m] * e).re));
                    row.push((2 * k + 1, -t * (a[m] * e).im));
                    row.push((base + 2 * k, e.re));
                    row.push((base + 2 * k + 1, -e.im));
                }
                for h in 0..harmonics as usize {
                    let angle = std::f64::consts::TAU * self.mains_hz * (h + 1) as f64 * t;
                    row.push((frequencies - 1, -self.hum * t * angle.sin()));
                    row.push((base + 2 * (self.modes.len() + h), angle.cos()));
                    row.push((base + 2 * (self.modes.len() + h) + 1, angle.sin()));
                }
                for &(i, a) in &row {
                    for &(j, b) in &row {
                        fisher[(i, j)] += a * b / (self.noise * self.noise);
                    }
                }
            }
        }
        let inverse = Cholesky::new(&fisher).unwrap().inverse();
        inverse.select(&[0, 1])
    }
}
