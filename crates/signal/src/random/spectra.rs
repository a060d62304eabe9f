//! Cross spectra of several channels by Welch's method, and transfer functions between them.

use crate::Fault;
use crate::dsp::transform;
use rijke_numerics::{C64, median};
use std::f64::consts::TAU;

/// Cross spectra, in a band of frequencies.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectra {
    /// Frequencies, Hz.
    pub frequency_hz: Vec<f64>,
    /// Number of independent averages.
    pub averages: f64,
    /// At every frequency the sums of conj(X_i) X_j over the segments, by i and j.
    pub(super) cross: Vec<Vec<Vec<C64>>>,
}

/// A transfer function at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TransferEstimate {
    /// H1: the cross spectrum over the spectrum of the channel below.
    pub value: C64,
    /// Coherence, 0 to 1.
    pub coherence: f64,
    /// Standard deviation of the real and of the imaginary part of its logarithm.
    pub relative_sd: f64,
}

impl TransferEstimate {
    /// The geometric mean of H1 and H2: the root of the ratio of the spectra, with the phase of the cross
    /// spectrum. Noise, and what echoes carry from segment to segment, make H1 too small by the coherence; of
    /// like size in both channels, they leave this one right.
    #[must_use]
    pub fn even(&self) -> C64 {
        self.value / self.coherence.max(f64::MIN_POSITIVE).sqrt()
    }
}

impl Spectra {
    /// Of channels of equal length in segments of so many samples with Hann's window, each half over the one
    /// before (Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70).
    ///
    /// # Errors
    /// [`Fault::Options`] for a rate or a band that is none; [`Fault::UnequalChannels`]; [`Fault::TooShort`]
    /// for less than two segments, or for one without a frequency in the band; [`Fault::NotFinite`];
    /// [`Fault::Spike`]; [`Fault::DeadChannel`] for one of a single value.
    pub fn welch(
        channels: &[Vec<f64>],
        rate_hz: f64,
        segment: usize,
        band_hz: [f64; 2],
    ) -> Result<Self, Fault> {
        asked(rate_hz, band_hz)?;
        let need = checked(channels)?;
        let step = (segment / 2).max(1);
        if need < segment + step {
            return Err(Fault::TooShort { what: "record", have: need, need: segment + step });
        }
        let window: Vec<f64> =
            (0..segment).map(|n| 0.5 - 0.5 * (TAU * n as f64 / segment as f64).cos()).collect();
        let spacing = rate_hz / segment as f64;
        let bins: Vec<usize> =
            (1..segment / 2).filter(|k| (band_hz[0]..=band_hz[1]).contains(&(*k as f64 * spacing))).collect();
        if bins.is_empty() {
            let need = (rate_hz / (band_hz[1] - band_hz[0]).max(f64::MIN_POSITIVE)).ceil() as usize;
            return Err(Fault::TooShort {
                what: "segment, for a frequency in the band,",
                have: segment,
                need,
            });
        }
        let n = channels.len();
        let mut cross = vec![vec![vec![C64::ZERO; n]; n]; bins.len()];
        let plan = transform::forward(segment);
        let starts: Vec<usize> = (0..).map(|k| k * step).take_while(|s| s + segment <= need).collect();
        for &start in &starts {
            let mut spectra = Vec::with_capacity(n);
            for channel in channels {
                let part = &channel[start..start + segment];
                let mean = part.iter().sum::<f64>() / segment as f64;
                let mut samples: Vec<f64> = part.iter().zip(&window).map(|(v, w)| (v - mean) * w).collect();
                let mut spectrum = plan.make_output_vec();
                // The lengths are those of the plan.
                let _ = plan.process(&mut samples, &mut spectrum);
                spectra.push(spectrum);
            }
            for (sums, &bin) in cross.iter_mut().zip(&bins) {
                for (i, sums) in sums.iter_mut().enumerate() {
                    for (j, sum) in sums.iter_mut().enumerate() {
                        *sum += spectra[i][bin].conj() * spectra[j][bin];
                    }
                }
            }
        }
        // Segments that overlap by half share 1/36 of the variance of their neighbours: Welch's equation for
        // Hann's window.
        let count = starts.len() as f64;
        let averages = count / (1.0 + 2.0 * (count - 1.0) / count / 36.0);
        Ok(Self { frequency_hz: bins.iter().map(|k| *k as f64 * spacing).collect(), averages, cross })
    }

    /// The same with one channel upside down.
    pub(super) fn inverted(&self, channel: usize) -> Self {
        let mut other = self.clone();
        for sums in &mut other.cross {
            for (i, row) in sums.iter_mut().enumerate() {
                let odd = |j: &usize| (i == channel) != (*j == channel);
                row.iter_mut().enumerate().filter(|(j, _)| odd(j)).for_each(|(_, sum)| *sum = -*sum);
            }
        }
        other
    }

    /// The same with two channels in each other's place.
    pub(super) fn exchanged(&self, a: usize, b: usize) -> Self {
        let mut other = self.clone();
        for sums in &mut other.cross {
            sums.swap(a, b);
            sums.iter_mut().for_each(|row| row.swap(a, b));
        }
        other
    }

    /// The transfer function from one channel to another. Its error is that of Bendat & Piersol, Random Data
    /// (4th ed. 2010), chapter 9.
    ///
    /// # Panics
    /// For a channel that is not there.
    #[must_use]
    pub fn transfer(&self, from: usize, to: usize) -> Vec<TransferEstimate> {
        let one = |s: &Vec<Vec<C64>>| {
            let (own, other) = (s[from][from].re, s[to][to].re);
            let value = s[from][to] / own;
            let coherence = (s[from][to].norm_sqr() / (own * other)).min(1.0);
            let sd = ((1.0 - coherence).max(1e-12) / (2.0 * coherence * self.averages)).sqrt();
            TransferEstimate { value, coherence, relative_sd: sd }
        };
        self.cross.iter().map(one).collect()
    }
}

/// Refuses a sampling rate that is no positive number, and a band that is not two frequencies in order.
pub(super) fn asked(rate_hz: f64, [low, high]: [f64; 2]) -> Result<(), Fault> {
    if !(rate_hz.is_finite() && rate_hz > 0.0) {
        return Err(Fault::Options("the sampling rate is no number above zero"));
    }
    if !(low >= 0.0 && high.is_finite() && low < high) {
        return Err(Fault::Options("the band is not two frequencies, the lower one first"));
    }
    Ok(())
}

/// Root mean squares of a channel beyond which a sample is no sound: Gaussian noise does not reach seven in a
/// day, sines not two.
const SPIKE: f64 = 40.0;

/// The length of channels that are alike in it, finite, without a spike, and none of them of a single value.
pub(super) fn checked(channels: &[Vec<f64>]) -> Result<usize, Fault> {
    let length = live_length(channels)?;
    for (channel, samples) in channels.iter().enumerate() {
        let mean = samples.iter().sum::<f64>() / length as f64;
        let square = samples.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / length as f64;
        let largest =
            samples.iter().enumerate().max_by(|a, b| (a.1 - mean).abs().total_cmp(&(b.1 - mean).abs()));
        if let Some((sample, value)) = largest {
            let ratio = (value - mean).abs() / square.sqrt();
            if ratio > SPIKE {
                return Err(Fault::Spike { channel: channel.into(), sample, ratio });
            }
        }
    }
    Ok(length)
}

/// The length of channels that are alike in it, finite, and none of them of a single value.
pub(crate) fn live_length(channels: &[Vec<f64>]) -> Result<usize, Fault> {
    let need = channels.first().map_or(0, Vec::len);
    if let Some(channel) = channels.iter().position(|c| c.len() != need) {
        return Err(Fault::UnequalChannels { channel: channel.into(), have: channels[channel].len(), need });
    }
    for (channel, samples) in channels.iter().enumerate() {
        if let Some(sample) = samples.iter().position(|v| !v.is_finite()) {
            return Err(Fault::NotFinite { channel: channel.into(), sample });
        }
    }
    let span = |c: &Vec<f64>| {
        c.iter().copied().reduce(f64::max).unwrap_or(0.0) - c.iter().copied().reduce(f64::min).unwrap_or(0.0)
    };
    let spans: Vec<f64> = channels.iter().map(span).collect();
    match spans.iter().position(|span| *span == 0.0) {
        Some(channel) => {
            Err(Fault::DeadChannel { channel: channel.into(), span: 0.0, median: median(spans) })
        }
        None => Ok(need),
    }
}
