//! The part of a click record around the impulse, its dispersion undone, and the noise there.

use crate::click::ClickOptions;
use crate::kernels::dot;
use crate::parabola::Parabola;
use crate::{Fault, Trace};
use rijke_numerics::C64;

/// Samples around the impulse; times count from the trigger.
#[derive(Clone, Debug)]
pub(crate) struct Segment {
    channels: Vec<Vec<f64>>,
    first: f64,
    step: f64,
    /// Highest frequency that the waveform may hold, Hz.
    pub(crate) highest_hz: f64,
    /// Standard deviation of the noise of each channel.
    pub(crate) noise: Vec<f64>,
    /// Whether the noise was measured; if not, it counts as 1.
    pub(crate) noise_known: bool,
}

/// What is kept before the first and after the last impulse, s.
const MARGIN: f64 = 6e-3;

impl Segment {
    pub(crate) fn new(trace: &Trace<'_>, times: &[f64], options: &ClickOptions) -> Result<Self, Fault> {
        let (step, quiet) = (1.0 / trace.rate_hz, trace.quiet.min(trace.len()));
        let sample = |t: f64| (t / step + quiet as f64).clamp(0.0, trace.len() as f64) as usize;
        let from = sample(times.iter().fold(f64::INFINITY, |a, &b| a.min(b)) - MARGIN);
        let to = sample(times.iter().fold(f64::NEG_INFINITY, |a, &b| a.max(b)) + MARGIN);
        // A power of two, if the record is long enough, for the sake of the transform.
        let to = (from + (to - from).next_power_of_two()).min(trace.len());
        let highest_hz = options.band_hz.1.min(0.4 * trace.rate_hz);
        let mut channels: Vec<Vec<f64>> = trace.channels.iter().map(|y| y[from..to].to_vec()).collect();
        let mut planner = realfft::RealFftPlanner::<f64>::new();
        for (y, &kappa) in channels.iter_mut().zip(&options.dispersion) {
            undo_dispersion(&mut planner, y, kappa, step, highest_hz)?;
        }
        let length = ((options.window.0 + options.window.1) / step) as usize;
        // The same windows on noise alone measure what the background leaves of it.
        let measured: Vec<Option<f64>> =
            trace.channels.iter().map(|y| noise(&y[..quiet], length.max(8))).collect();
        let noise_known = measured.iter().all(Option::is_some);
        let noise = measured.into_iter().map(|n| n.filter(|_| noise_known).unwrap_or(1.0)).collect();
        let first = (from as f64 - quiet as f64) * step;
        Ok(Self { channels, first, step, highest_hz, noise, noise_known })
    }

    pub(crate) fn time(&self, n: usize) -> f64 {
        self.first + n as f64 * self.step
    }

    pub(crate) fn at(&self, m: usize, n: usize) -> f64 {
        self.channels[m][n]
    }

    /// First and one past the last sample of the window of each channel.
    pub(crate) fn windows(&self, times: &[f64], options: &ClickOptions) -> Vec<(usize, usize)> {
        let sample =
            |t: f64| ((t - self.first) / self.step).ceil().clamp(0.0, self.channels[0].len() as f64) as usize;
        let window = |(m, t): (usize, &f64)| {
            let from = sample(t - options.window.0);
            (from, sample(t + options.end(m)).max(from + 4).min(self.channels[0].len()))
        };
        times.iter().enumerate().map(window).collect()
    }
}

/// Standard deviation of what parabolas over stretches of `length` samples leave; none if there are fewer than four.
fn noise(quiet: &[f64], length: usize) -> Option<f64> {
    let (mut squares, mut freedom) = (0.0, 0);
    let parabola = Parabola::new(length);
    for stretch in quiet.chunks_exact(length) {
        let mut left = stretch.to_vec();
        parabola.remove(&mut left);
        squares += dot(&left, &left);
        freedom += length - 3;
    }
    let deviation = (squares / freedom.max(1) as f64).sqrt();
    (freedom >= 4 * (length - 3) && deviation > 0.0).then_some(deviation)
}

/// Multiplies the spectrum with e^{(1+i) kappa sqrt(omega)}, held constant above the band.
fn undo_dispersion(
    planner: &mut realfft::RealFftPlanner<f64>,
    y: &mut [f64],
    kappa: f64,
    step: f64,
    highest_hz: f64,
) -> Result<(), Fault> {
    let length = y.len();
    let failed = |_| Fault::TooShort { what: "record around the impulse", have: length, need: 2 };
    let mean = y.iter().sum::<f64>() / length.max(1) as f64;
    let mut samples: Vec<f64> = y.iter().map(|v| v - mean).collect();
    let forward = planner.plan_fft_forward(length);
    let mut spectrum = forward.make_output_vec();
    forward.process(&mut samples, &mut spectrum).map_err(failed)?;
    for (k, value) in spectrum.iter_mut().enumerate() {
        let frequency = k as f64 / (length as f64 * step);
        let root = kappa * (std::f64::consts::TAU * frequency.min(highest_hz)).sqrt();
        *value *= C64::new(root, root).exp();
    }
    if let Some(last) = spectrum.last_mut().filter(|_| length.is_multiple_of(2)) {
        last.im = 0.0;
    }
    planner.plan_fft_inverse(length).process(&mut spectrum, &mut samples).map_err(failed)?;
    for (out, v) in y.iter_mut().zip(&samples) {
        *out = v / length as f64 + mean;
    }
    Ok(())
}
