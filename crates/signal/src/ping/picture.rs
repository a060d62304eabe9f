//! The numbers of pictures of a fit: to be drawn, not to be computed with.

use super::found::PingFit;
use super::silence::MIN_QUIET;
use crate::Trace;
use rijke_numerics::C64;

/// One channel of a ring-down and its fit. Points are `[x, y]`, times in s from the first sample of the
/// record.
#[derive(Clone, Debug)]
pub struct PingPicture {
    /// The channel.
    pub channel: usize,
    /// From 20 ms before the window of the fit to its end.
    pub record: Vec<[f64; 2]>,
    /// Sum of all tones fitted.
    pub fit: Vec<[f64; 2]>,
    /// Record less fit.
    pub residual: Vec<[f64; 2]>,
    /// Amplitude density of the record in the window, unit of the record per root Hz over Hz.
    pub spectrum: Vec<[f64; 2]>,
    /// The same of the residual.
    pub residual_spectrum: Vec<[f64; 2]>,
}

impl PingFit {
    /// The numbers of a picture of the channel of largest amplitude.
    #[must_use]
    pub fn picture(&self, trace: &Trace<'_>) -> PingPicture {
        let size = |m: &usize| self.amplitudes[*m].norm();
        let channel =
            (0..self.amplitudes.len()).max_by(|a, b| size(a).total_cmp(&size(b))).unwrap_or_default();
        let sample = |t: f64| ((t * trace.rate_hz).round().max(0.0) as usize).min(trace.len());
        let (from, to) = (sample(self.window.0), sample(self.window.1));
        let time = |n: usize| n as f64 / trace.rate_hz;
        let levelled = trace.levelled(MIN_QUIET);
        let y = &levelled.as_deref().unwrap_or(trace.channels)[channel];
        let model = |n: usize| -> f64 {
            let after = time(n) - self.window.0;
            self.tones.iter().map(|(s, amplitudes)| (amplitudes[channel] * (s * after).exp()).re).sum()
        };
        let fit: Vec<[f64; 2]> = (from..to).map(|n| [time(n), model(n)]).collect();
        let left: Vec<f64> = (from..to).zip(&fit).map(|(n, p)| y[n] - p[1]).collect();
        PingPicture {
            channel,
            record: (sample(self.window.0 - 0.02)..to).map(|n| [time(n), y[n]]).collect(),
            spectrum: density(&y[from..to], trace.rate_hz),
            residual_spectrum: density(&left, trace.rate_hz),
            residual: fit.iter().zip(&left).map(|(p, r)| [p[0], *r]).collect(),
            fit,
        }
    }
}

/// Amplitude density up to 1.5 kHz, the mean over some 4 Hz. The window is the falling half of Hann's: what a
/// ring-down holds, it holds at its beginning.
fn density(y: &[f64], rate_hz: f64) -> Vec<[f64; 2]> {
    let n = y.len();
    let window = |k: usize| 1.0 + (std::f64::consts::PI * (k as f64 + 0.5) / n as f64).cos();
    let mut weighted: Vec<f64> = y.iter().enumerate().map(|(k, v)| v * window(k)).collect();
    let energy: f64 = (0..n).map(|k| window(k).powi(2)).sum();
    let transform = realfft::RealFftPlanner::<f64>::new().plan_fft_forward(n);
    let mut spectrum: Vec<C64> = transform.make_output_vec();
    if n < 2 || transform.process(&mut weighted, &mut spectrum).is_err() {
        return Vec::new();
    }
    let resolution = rate_hz / n as f64;
    let bins = ((4.0 / resolution).round() as usize).max(1);
    let means = spectrum.chunks_exact(bins).enumerate().map(|(k, bins)| {
        let power = bins.iter().map(C64::norm_sqr).sum::<f64>() / bins.len() as f64;
        let middle = (k as f64 + 0.5) * bins.len() as f64 - 0.5;
        [middle * resolution, (2.0 * power / (rate_hz * energy)).sqrt()]
    });
    means.take_while(|p| p[0] < 1500.0).collect()
}

#[cfg(test)]
mod tests {
    use super::density;

    #[test]
    fn oracle_density_of_white_noise_and_power_of_a_tone() {
        // A tone of amplitude 2 at 200 Hz: its density squared, summed over Hz, is its mean square 2.
        let y: Vec<f64> = (0..5000).map(|n| 2.0 * (0.125_664 * f64::from(n)).sin()).collect();
        let spectrum = density(&y, 1e4);
        let power: f64 = spectrum.iter().map(|p| p[1] * p[1] * (spectrum[1][0] - spectrum[0][0])).sum();
        // The window begins abruptly: some power leaks beyond 1.5 kHz.
        assert!((power - 2.0).abs() < 0.02, "{power}");
    }
}
