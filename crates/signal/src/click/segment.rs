//! The part of a click record around the impulse, at the rate that its band needs, its dispersion undone, and
//! the noise there.

use super::options::ClickOptions;
use crate::dsp::kernels::dot;
use crate::dsp::parabola::Parabola;
use crate::dsp::transform;
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

/// What is kept before the first and after the last impulse, s. The outer half fades away, at most [`FADE`].
const MARGIN: f64 = 6e-3;
const FADE: f64 = 3e-3;
/// Highest frequency of a waveform over the sampling rate, at most.
pub(crate) const HIGHEST_HZ: f64 = 0.4;
/// Samples at each end of the decimated noise that are left out: they have seen the other end.
const ENDS: usize = 8;

/// How many times less often than the record a band up to `highest_hz` needs to be sampled: at least 7 times
/// as often as its highest frequency. White noise stays white, and what of it is in the band stays the same.
/// Half of that would do for the impulse, but windows end at samples: at 64 us, what they hold of a
/// reflection would jump from click to click.
pub(crate) fn decimation(rate_hz: f64, highest_hz: f64) -> usize {
    1 << ((rate_hz / (7.0 * highest_hz)) as usize).max(1).ilog2()
}

impl Segment {
    pub(crate) fn new(trace: &Trace<'_>, times: &[f64], options: &ClickOptions) -> Result<Self, Fault> {
        let (step, quiet) = (1.0 / trace.rate_hz, trace.quiet.min(trace.len()));
        let highest_hz = options.band_hz.1.min(HIGHEST_HZ * trace.rate_hz);
        let factor = decimation(trace.rate_hz, options.band_hz.1);
        let sample = |t: f64| (t / step + quiet as f64).clamp(0.0, trace.len() as f64) as usize;
        let earliest = times.iter().fold(f64::INFINITY, |a, &b| a.min(b)) - options.window.0;
        let latest = times.iter().fold(f64::NEG_INFINITY, |a, &b| a.max(b)) + options.window.1;
        let from = sample(earliest + options.window.0 - MARGIN);
        let to = sample(latest - options.window.1 + MARGIN);
        // A power of two, if the record is long enough, for the sake of the transform.
        let to = (from + (to - from).next_power_of_two()).min(trace.len());
        let to = to - (to - from) % factor;
        let first = (from as f64 - quiet as f64) * step;
        let fade = |room: f64| ((0.5 * room).clamp(0.0, FADE) / step) as usize;
        let fades = [fade(earliest - first), fade(first + (to - from) as f64 * step - latest)];
        let kappa = |m: usize| options.dispersion.get(m).copied().unwrap_or(0.0);
        let mut channels = Vec::with_capacity(trace.channels.len());
        for (m, y) in trace.channels.iter().enumerate() {
            channels.push(resampled(&faded(&y[from..to], fades), factor, kappa(m), step, highest_hz)?);
        }
        let length = ((options.window.0 + options.window.1) / (step * factor as f64)) as usize;
        // The same windows on noise alone measure what the background leaves of it. What undoes the
        // dispersion makes it louder: the boundary layers have not weakened it.
        let mut measured = Vec::with_capacity(channels.len());
        for (m, y) in trace.channels.iter().enumerate() {
            let quiet = &y[..quiet - quiet % factor];
            let deviation = if quiet.len() < 4 * ENDS * factor {
                noise(quiet, length)
            } else {
                let y = resampled(quiet, factor, kappa(m), step, highest_hz)?;
                noise(&y[ENDS..y.len() - ENDS], length)
            };
            measured.push(deviation);
        }
        let noise_known = measured.iter().all(Option::is_some);
        let noise = measured.into_iter().map(|n| n.filter(|_| noise_known).unwrap_or(1.0)).collect();
        Ok(Self { channels, first, step: step * factor as f64, highest_hz, noise, noise_known })
    }

    pub(crate) fn time(&self, n: usize) -> f64 {
        self.first + n as f64 * self.step
    }

    pub(crate) fn at(&self, m: usize, n: usize) -> f64 {
        self.channels[m][n]
    }

    /// Adds to a sample of channel `m`.
    pub(crate) fn add(&mut self, m: usize, n: usize, value: f64) {
        self.channels[m][n] += value;
    }

    /// First and one past the last sample of the window of each channel.
    pub(crate) fn windows(&self, times: &[f64], options: &ClickOptions) -> Vec<(usize, usize)> {
        let length = self.channels[0].len();
        let sample = |t: f64| ((t - self.first) / self.step).ceil().clamp(0.0, length as f64) as usize;
        let window = |(m, t): (usize, &f64)| {
            let from = sample(t - options.window.0).min(length.saturating_sub(4));
            (from, sample(t + options.end(m)).max(from + 4).min(length))
        };
        times.iter().enumerate().map(window).collect()
    }
}

/// Standard deviation of what parabolas over stretches of `length` samples leave, or over a quarter of the
/// quiet part if that is shorter; none if this is shorter than eight.
fn noise(quiet: &[f64], length: usize) -> Option<f64> {
    let length = length.min(quiet.len() / 4).max(8);
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

/// Samples less their mean that rise from and fall to zero along cosines of so many samples.
fn faded(y: &[f64], [rise, fall]: [usize; 2]) -> Vec<f64> {
    let mean = y.iter().sum::<f64>() / y.len().max(1) as f64;
    let mut left: Vec<f64> = y.iter().map(|v| v - mean).collect();
    let weight =
        |n: usize, length: usize| 0.5 - 0.5 * (std::f64::consts::PI * (n as f64 + 0.5) / length as f64).cos();
    left.iter_mut().take(rise).enumerate().for_each(|(n, v)| *v *= weight(n, rise));
    left.iter_mut().rev().take(fall).enumerate().for_each(|(n, v)| *v *= weight(n, fall));
    left
}

/// Every `factor`th sample of what is left below half the new rate, with the spectrum multiplied by e^{(1+i)
/// kappa sqrt(omega)}, held constant above `highest_hz`. The number of samples is a multiple of `factor`.
fn resampled(y: &[f64], factor: usize, kappa: f64, step: f64, highest_hz: f64) -> Result<Vec<f64>, Fault> {
    let (length, short) = (y.len(), y.len() / factor);
    let failed = |_| Fault::TooShort { what: "record around the impulse", have: length, need: 2 };
    if factor == 1 && kappa == 0.0 || short < 2 {
        return Ok(y.to_vec());
    }
    let forward = transform::forward(length);
    let (mut samples, mut spectrum) = (y.to_vec(), forward.make_output_vec());
    forward.process(&mut samples, &mut spectrum).map_err(failed)?;
    spectrum.truncate(short / 2 + 1);
    if kappa != 0.0 {
        let resolution = 1.0 / (length as f64 * step);
        let turn = |f: f64| {
            let root = kappa * (std::f64::consts::TAU * f).sqrt();
            C64::new(root, root).exp()
        };
        let below = ((highest_hz / resolution) as usize + 1).min(spectrum.len());
        let (low, high) = spectrum.split_at_mut(below);
        low.iter_mut().enumerate().for_each(|(k, value)| *value *= turn(k as f64 * resolution));
        let held = turn(highest_hz);
        high.iter_mut().for_each(|value| *value *= held);
    }
    if let Some(last) = spectrum.last_mut().filter(|_| short.is_multiple_of(2)) {
        last.im = 0.0;
    }
    if let Some(first) = spectrum.first_mut() {
        first.im = 0.0;
    }
    let mut out = vec![0.0; short];
    transform::inverse(short).process(&mut spectrum, &mut out).map_err(failed)?;
    let scale = (length as f64).recip();
    out.iter_mut().for_each(|v| *v *= scale);
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn oracle_a_band_limited_impulse_and_white_noise_survive_decimation() {
        let (rate, step) = (62_500.0, 1.0 / 62_500.0);
        assert_eq!((decimation(rate, 4000.0), decimation(1e4, 4000.0), decimation(192e3, 4000.0)), (2, 1, 4));
        let impulse = |t: f64| {
            let a = (std::f64::consts::PI * 1500.0 * (t - 8.1e-3)).powi(2);
            (1.0 - 2.0 * a) * (-a).exp()
        };
        let y: Vec<f64> = (0..1024).map(|n| impulse(f64::from(n) * step)).collect();
        for (n, v) in resampled(&y, 4, 0.0, step, 4000.0).unwrap().iter().enumerate() {
            assert!((v - impulse(4.0 * n as f64 * step)).abs() < 1e-9, "{n}: {v}");
        }
        // Uniform numbers of a congruence: variance 1/12, a quarter of it below half the new rate.
        let mut state = 1_u32;
        let mut uniform = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state) / f64::from(u32::MAX) - 0.5
        };
        let white: Vec<f64> = (0..1 << 16).map(|_| uniform()).collect();
        let less = resampled(&white, 4, 0.0, step, 4000.0).unwrap();
        let variance = dot(&less, &less) / less.len() as f64;
        assert!((variance * 48.0 - 1.0).abs() < 0.04, "{variance}");
        let neighbours = dot(&less[1..], &less[..less.len() - 1]) / dot(&less, &less);
        assert!(neighbours.abs() < 0.03, "{neighbours}");
    }
}
