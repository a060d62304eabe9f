//! A first guess of the frequencies: ESPRIT (Roy & Kailath 1989) on the record, decimated, all channels
//! together.

use super::white::White;
use crate::Fault;
use rijke_numerics::{C64, Matrix, complex_eigenvalues, symmetric_eigen};

/// Length of the shifted windows, in decimated samples; their subspace of at most [`MAX_POLES`] carries the
/// signal.
const WINDOW: usize = 36;
/// Largest number of poles taken: two for every real tone.
const MAX_POLES: usize = 16;

/// A low-passed and decimated copy of a white record.
#[derive(Clone, Debug)]
pub(crate) struct Decimated {
    samples: Vec<f64>,
    channels: usize,
    step: f64,
    /// Variance of its noise, if that of the record is 1.
    pub(crate) variance: f64,
}

impl Decimated {
    /// Keeps frequencies up to 0.4 times the new sampling rate, which is `factor` times lower than the old
    /// one.
    pub(crate) fn new(white: White<'_>, factor: usize) -> Self {
        let half = if factor == 1 { 0 } else { 4 * factor };
        let taps = low_pass(half, 0.4 / factor as f64);
        let channels = white.channels;
        let rows = white.rows().saturating_sub(2 * half).div_ceil(factor);
        let mut samples = vec![0.0; rows * channels];
        for (row, out) in samples.chunks_exact_mut(channels).enumerate() {
            let window = &white.samples[row * factor * channels..];
            for (tap, input) in taps.iter().zip(window.chunks_exact(channels)) {
                for (o, i) in out.iter_mut().zip(input) {
                    *o += tap * i;
                }
            }
        }
        let variance = taps.iter().map(|h| h * h).sum();
        Self { samples, channels, step: white.step * factor as f64, variance }
    }

    pub(crate) fn white(&self) -> White<'_> {
        White { samples: &self.samples, channels: self.channels, step: self.step }
    }
}

/// Windowed-sinc low-pass filter of 2 `half` + 1 taps and unit sum; `cut` in cycles per sample.
fn low_pass(half: usize, cut: f64) -> Vec<f64> {
    let mut taps: Vec<f64> = (0..=2 * half)
        .map(|n| {
            let t = n as f64 - half as f64;
            let sinc = if t == 0.0 {
                2.0 * cut
            } else {
                (std::f64::consts::TAU * cut * t).sin() / (std::f64::consts::PI * t)
            };
            sinc * (0.54 + 0.46 * (std::f64::consts::PI * t / (half as f64 + 1.0)).cos())
        })
        .collect();
    let sum: f64 = taps.iter().sum();
    taps.iter_mut().for_each(|h| *h /= sum);
    taps
}

/// Poles s (1/s, positive frequency only) of the exponentials that all channels share, in no particular
/// order. More may be returned than are real: the caller keeps those that explain the record.
pub(crate) fn poles(data: &Decimated) -> Result<Vec<C64>, Fault> {
    let white = data.white();
    let (channels, samples) = (white.channels, white.samples);
    let rows = white.rows();
    if rows < 3 * WINDOW {
        return Err(Fault::TooShort { what: "decay", have: rows, need: 3 * WINDOW });
    }
    let windows = rows - WINDOW + 1;
    let row = |n: usize| &samples[n * channels..(n + 1) * channels];
    let product = |a: usize, b: usize| -> f64 { row(a).iter().zip(row(b)).map(|(x, y)| x * y).sum() };
    let mut covariance = Matrix::zeros(WINDOW, WINDOW);
    for j in 0..WINDOW {
        let (a, b) = (&samples[..windows * channels], &samples[j * channels..(j + windows) * channels]);
        let value = a.iter().zip(b).map(|(x, y)| x * y).sum();
        covariance[(0, j)] = value;
        covariance[(j, 0)] = value;
    }
    // The other entries follow along each diagonal by one sample in and one sample out.
    for i in 1..WINDOW {
        for j in i..WINDOW {
            let value = covariance[(i - 1, j - 1)] - product(i - 1, j - 1)
                + product(i + windows - 1, j + windows - 1);
            covariance[(i, j)] = value;
            covariance[(j, i)] = value;
        }
    }
    let (values, vectors) = symmetric_eigen(&covariance)?;
    // Eigenvalues of noise alone cluster within a few per cent of their median.
    let noise = values[WINDOW / 2];
    let signal = values.iter().filter(|&&v| v > 1.3 * noise).count().clamp(2, MAX_POLES);
    let subspace = |i: usize, j: usize| vectors[(i, WINDOW - signal + j)];
    let upper = Matrix::from_fn(WINDOW - 1, signal, subspace);
    let lower = Matrix::from_fn(WINDOW - 1, signal, |i, j| subspace(i + 1, j));
    // (U1' U1)^-1 = I + u u' / (1 - u'u), with u the row that the orthonormal columns lose.
    let last: Vec<f64> = (0..signal).map(|j| subspace(WINDOW - 1, j)).collect();
    let lost: f64 = last.iter().map(|v| v * v).sum();
    let inverse = Matrix::from_fn(signal, signal, |i, j| {
        f64::from(u8::from(i == j)) + last[i] * last[j] / (1.0 - lost)
    });
    let shift = inverse.product(&upper.transpose().product(&lower));
    let shift: Vec<C64> = shift.as_slice().iter().map(|&v| C64::from(v)).collect();
    let poles = complex_eigenvalues(&shift, signal)?;
    Ok(poles.into_iter().map(|z| z.ln() / white.step).filter(|s| s.im > 0.0 && s.is_finite()).collect())
}
