//! Noise of a channel: white at high frequency, 1/f below a corner, mains and its harmonics.

use crate::truth;
use rand::RngExt;
use rand_distr::StandardNormal;
use rijke_numerics::{Cholesky, Matrix, Stream};
use std::f64::consts::{PI, TAU};

/// The filter that turns white noise into noise whose density rises as 1/f below a corner: a product of three
/// lags (1 + f/z)/(1 + f/p), each a factor 6 below the last, zero and pole sqrt(6) apart, in parallel form
/// H = direct + sum_k weight_k / (1 - pole_k/z). The density is flat again below the lowest pole, a hundredth
/// of the corner.
#[derive(Clone, Debug)]
pub(crate) struct Colour {
    direct: f64,
    weights: [f64; LAGS],
    poles: [f64; LAGS],
    /// Lower triangle that turns independent normals into a stationary start.
    start: Option<Matrix>,
    sd: f64,
}

const LAGS: usize = 3;

/// The mains as one record sees it.
#[derive(Clone, Debug)]
pub(crate) struct Hum {
    /// Step of the angle per sample of each harmonic, amplitude, angle at the first sample.
    harmonics: Vec<(f64, f64, f64)>,
}

impl Colour {
    /// For a sampling rate, Hz.
    #[must_use]
    pub(crate) fn new(noise: &truth::NoiseLevels, rate_hz: f64) -> Self {
        let discrete = |f: f64| (-TAU * f / rate_hz).exp();
        let zeros: [f64; LAGS] = std::array::from_fn(|k| discrete(noise.corner_hz / 6_f64.powi(k as i32)));
        let poles: [f64; LAGS] =
            std::array::from_fn(|k| discrete(noise.corner_hz / 6_f64.powi(k as i32) / 6_f64.sqrt()));
        // Gain 1 at half the sampling rate: there the noise is white.
        let gain: f64 = zeros.iter().zip(&poles).map(|(b, a)| (1.0 + a) / (1.0 + b)).product();
        let direct = zeros.iter().zip(&poles).map(|(b, a)| b / a).product();
        let weights = std::array::from_fn(|k| {
            let upper: f64 = zeros.iter().map(|b| 1.0 - b / poles[k]).product();
            let others = poles.iter().enumerate().filter(|(j, _)| *j != k);
            upper / others.map(|(_, a)| 1.0 - a / poles[k]).product::<f64>()
        });
        // All lags are driven by the same noise: E[y_i y_j] = 1/(1 - a_i a_j).
        let covariance = Matrix::from_fn(LAGS, LAGS, |i, j| 1.0 / (1.0 - poles[i] * poles[j]));
        let start = Cholesky::new(&covariance).ok().map(|c| c.lower().clone());
        Self { direct, weights, poles, start, sd: gain * noise.white_pa_rt_hz * (0.5 * rate_hz).sqrt() }
    }

    /// Adds noise to `samples`.
    pub(crate) fn add(&self, samples: &mut [f64], stream: &mut Stream) {
        let mut state = [0.0; LAGS];
        if let Some(lower) = &self.start {
            let normals: [f64; LAGS] = std::array::from_fn(|_| stream.sample(StandardNormal));
            for i in 0..LAGS {
                state[i] = (0..=i).map(|j| lower[(i, j)] * normals[j]).sum();
            }
        }
        for sample in samples {
            let white: f64 = stream.sample(StandardNormal);
            let mut y = self.direct * white;
            for k in 0..LAGS {
                state[k] = self.poles[k] * state[k] + white;
                y += self.weights[k] * state[k];
            }
            *sample += self.sd * y;
        }
    }
}

impl Hum {
    /// With angles drawn for one record.
    pub(crate) fn new(noise: &truth::NoiseLevels, rate_hz: f64, stream: &mut Stream) -> Self {
        let step = TAU * noise.mains_hz / rate_hz;
        let harmonic =
            |(k, amplitude): (usize, &f64)| ((k + 1) as f64 * step, *amplitude, stream.random_range(-PI..PI));
        Self { harmonics: noise.mains_pa.iter().enumerate().map(harmonic).collect() }
    }

    /// Adds the hum, `factor` times, to samples that start with number `first` of the record.
    pub(crate) fn add(&self, samples: &mut [f64], first: usize, factor: f64) {
        for (step, amplitude, angle) in &self.harmonics {
            let (sin, cos) = step.sin_cos();
            let (mut y, mut x) = (angle + step * first as f64).sin_cos();
            for sample in samples.iter_mut() {
                *sample += factor * amplitude * x;
                (x, y) = (x * cos - y * sin, x * sin + y * cos);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::truth::Truth;
    use realfft::RealFftPlanner;
    use rijke_numerics::Streams;

    #[test]
    fn oracle_density_is_white_above_and_one_over_f_below_the_corner() {
        let noise = Truth::standard().noise;
        let (rate, length) = (1000.0, 1 << 16);
        let (colour, plan) =
            (Colour::new(&noise, rate), RealFftPlanner::<f64>::new().plan_fft_forward(length));
        let mut density = vec![0.0; length / 2 + 1];
        for k in 0..20 {
            let mut samples = vec![0.0; length];
            colour.add(&mut samples, &mut Streams::new(1).stream(&format!("noise/{k}")));
            let mut spectrum = plan.make_output_vec();
            plan.process(&mut samples, &mut spectrum).unwrap();
            for (d, z) in density.iter_mut().zip(&spectrum) {
                *d += z.norm_sqr() * 2.0 / (rate * length as f64) / 20.0;
            }
        }
        let mean = |low: f64, high: f64| {
            let bin = |f: f64| (f / rate * length as f64) as usize;
            let band = &density[bin(low)..bin(high)];
            band.iter().sum::<f64>() / band.len() as f64
        };
        let white = noise.white_pa_rt_hz.powi(2);
        assert!((mean(300.0, 450.0) / white - 1.0).abs() < 0.05, "{}", mean(300.0, 450.0) / white);
        let slope = (mean(0.45, 0.55) / mean(4.5, 5.5)).log10();
        assert!((slope - 1.0).abs() < 0.1, "one decade changes the density by 10^{slope}");
    }

    #[test]
    fn exact_hum_is_a_sum_of_cosines() {
        let noise = Truth::standard().noise;
        let hum = Hum::new(&noise, 10_000.0, &mut Streams::new(3).stream("hum"));
        let mut samples = vec![0.0; 3000];
        hum.add(&mut samples[1000..], 1000, 2.0);
        assert_eq!(samples[999], 0.0);
        let direct = |n: f64| hum.harmonics.iter().map(|(w, a, f)| 2.0 * a * (w * n + f).cos()).sum::<f64>();
        assert!((samples[2999] - direct(2999.0)).abs() < 1e-12);
    }
}
