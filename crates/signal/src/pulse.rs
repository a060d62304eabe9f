//! Where an impulse is in a record, and its spectrum in a window that moves with it.

use crate::click::{ClickOptions, Weighting};
use crate::noise::invert_lower;
use crate::{Fault, Trace};
use rijke_numerics::{C64, Cholesky, Matrix};
use std::f64::consts::{PI, TAU};

/// Half length of the smoothing kernel of the high-pass filter, s: hum at 50 Hz falls to 3e-4, and what the filter
/// smears from later reflections into the window is below their mean over 3 ms.
const SMOOTHING: f64 = 1.5e-3;
/// Largest shift between a channel and the strongest one that the first alignment corrects, s.
const REACH: f64 = 0.35e-3;

/// Impulses found to about a sample.
#[derive(Clone, Debug)]
pub(crate) struct Located {
    /// High-passed channels, from sample `begin` of the record on.
    channels: Vec<Vec<f64>>,
    begin: usize,
    pub(crate) quiet: usize,
    rate_hz: f64,
    /// Arrival times after the end of the quiet part, s.
    pub(crate) times: Vec<f64>,
    /// Gains relative to the strongest channel.
    pub(crate) gains: Vec<f64>,
    pub(crate) pivot: usize,
}

impl Located {
    pub(crate) fn find(trace: &Trace<'_>, options: &ClickOptions) -> Result<Self, Fault> {
        let half = ((SMOOTHING * trace.rate_hz).ceil() as usize).max(2);
        trace.screen(8 * half)?;
        let quiet = trace.quiet.min(trace.len());
        let begin = 2 * (half - 1);
        let channels: Vec<Vec<f64>> = trace.channels.iter().map(|y| high_pass(y, half)).collect();
        let spread = (0.3e-3 * trace.rate_hz).ceil() as usize;
        let silence = quiet.saturating_sub(begin + spread);
        let mut found = Vec::new();
        for (m, z) in channels.iter().enumerate() {
            found.push(first_burst(z, silence, spread).ok_or_else(|| no_impulse(m, z, silence))?);
        }
        // A reflection that overlaps the direct impulse hides its shape: such a channel cannot lead the others.
        let pivot = (0..found.len())
            .filter(|&m| !options.overlaps(m))
            .max_by(|&a, &b| found[a].1.total_cmp(&found[b].1))
            .unwrap_or(0);
        let margin =
            ((options.flat.0 + options.flat.1 + 2.0 * options.edge + REACH) * trace.rate_hz) as usize;
        let mut located = Self {
            channels,
            begin,
            quiet,
            rate_hz: trace.rate_hz,
            times: Vec::new(),
            gains: Vec::new(),
            pivot,
        };
        let length = located.channels[0].len();
        if found.iter().any(|&(n, _)| n < margin || n + margin >= length) {
            return Err(Fault::TooShort {
                what: "record around the impulse",
                have: length,
                need: 2 * margin,
            });
        }
        let centre = centroid(&located.channels[pivot], found[pivot].0, spread);
        for (m, &(n, _)) in found.iter().enumerate() {
            let (lag, gain) = align(&located.channels[pivot], centre, &located.channels[m], n, trace.rate_hz);
            let sample = (lag + begin) as f64 - quiet as f64;
            located.times.push(sample / trace.rate_hz);
            located.gains.push(gain);
        }
        Ok(located)
    }
}

fn no_impulse(channel: usize, z: &[f64], silence: usize) -> Fault {
    let rms = |y: &[f64]| (y.iter().map(|v| v * v).sum::<f64>() / y.len().max(1) as f64).sqrt();
    let peak = z[silence..].iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    let ratio = peak / rms(&z[..silence.max(1)]);
    Fault::NoSignal { channel, ratio, median: f64::INFINITY }
}

/// Twice over, y less its mean under a triangle of half length `half`: a linear-phase high-pass filter of finite
/// length, 2 `half` on each side, so that what comes later in the record reaches back by no more than that.
fn high_pass(y: &[f64], half: usize) -> Vec<f64> {
    let once = |y: &[f64]| -> Vec<f64> {
        let smooth = running_mean(&running_mean(y, half), half);
        // The two means together are centred `half` - 1 samples after their first sample.
        y[half - 1..].iter().zip(&smooth).map(|(a, b)| a - b).collect()
    };
    once(&once(y))
}

/// Means of `length` successive samples.
fn running_mean(y: &[f64], length: usize) -> Vec<f64> {
    let mut sum: f64 = y[..length - 1].iter().sum();
    (length - 1..y.len())
        .map(|n| {
            sum += y[n];
            let mean = sum / length as f64;
            sum -= y[n + 1 - length];
            mean
        })
        .collect()
}

/// Sample of the first burst that holds a good part of the largest energy of any burst, and its energy. None if no
/// burst stands out of the noise before `silence`.
fn first_burst(z: &[f64], silence: usize, spread: usize) -> Option<(usize, f64)> {
    let mut energy = Vec::with_capacity(z.len());
    let mut sum: f64 = z.iter().take(spread).map(|v| v * v).sum();
    for n in 0..z.len().saturating_sub(spread) {
        energy.push(sum);
        sum += z[n + spread].powi(2) - z[n].powi(2);
    }
    let noise = energy[..silence.min(energy.len())].iter().fold(0.0_f64, |a, &b| a.max(b));
    let later = energy.get(silence..)?;
    let top = later.iter().fold(0.0_f64, |a, &b| a.max(b));
    if top < 4.0 * noise {
        return None;
    }
    let mut n = later.iter().position(|&e| e > 0.4 * top)?;
    while n + 1 < later.len()
        && later[n + 1..later.len().min(n + 1 + spread / 3)].iter().any(|&e| e > later[n])
    {
        n += 1;
    }
    Some((silence + n + spread / 2, later[n]))
}

/// Centre of energy near sample `n`.
fn centroid(z: &[f64], n: usize, spread: usize) -> usize {
    let (mut mass, mut moment) = (0.0, 0.0);
    for i in n.saturating_sub(spread)..(n + spread).min(z.len()) {
        mass += z[i] * z[i];
        moment += i as f64 * z[i] * z[i];
    }
    (moment / mass).round() as usize
}

/// Sample of `other` that matches sample `centre` of `pivot`, by the largest correlation of either sign near `near`,
/// and the gain at that lag. Of two similar maxima the earlier is taken: a reflection comes later.
fn align(pivot: &[f64], centre: usize, other: &[f64], near: usize, rate_hz: f64) -> (usize, f64) {
    let half = (0.4e-3 * rate_hz) as usize;
    let reach = (REACH * rate_hz) as usize;
    let reference = &pivot[centre - half..centre + half];
    let power: f64 = reference.iter().map(|v| v * v).sum();
    let correlations: Vec<(usize, f64)> = (near - reach..near + reach)
        .filter(|&n| n >= half && n + half <= other.len())
        .map(|n| {
            let product: f64 = reference.iter().zip(&other[n - half..n + half]).map(|(a, b)| a * b).sum();
            (n, product / power)
        })
        .collect();
    let top = correlations.iter().fold(0.0_f64, |a, c| a.max(c.1.abs()));
    let peaks = correlations.windows(3).filter(|w| {
        w[1].1.abs() >= w[0].1.abs() && w[1].1.abs() >= w[2].1.abs() && w[1].1.abs() > 0.85 * top
    });
    peaks.map(|w| w[1]).next().unwrap_or((near, 1.0))
}

/// Spectra of all channels in windows centred on the impulse.
#[derive(Clone, Debug)]
pub(crate) struct Spectra {
    pub(crate) frequencies: Vec<f64>,
    values: Vec<Vec<C64>>,
    /// Middle of the window of each channel, s.
    middles: Vec<f64>,
    noise: Vec<f64>,
    /// Inverse Cholesky factor of the covariance between frequencies, for phases that count from the middle.
    whitener: Matrix,
    /// Whether the noise was learnt; if not, its size is arbitrary.
    pub(crate) noise_known: bool,
}

impl Spectra {
    pub(crate) fn bins(&self) -> usize {
        self.frequencies.len()
    }

    pub(crate) fn at(&self, m: usize, k: usize) -> C64 {
        self.values[m][k]
    }

    /// A spectrum of channel `m` in units of its noise: real and imaginary parts independent, of unit variance.
    pub(crate) fn whiten(&self, m: usize, values: &[C64]) -> Vec<C64> {
        let turned: Vec<C64> = self
            .frequencies
            .iter()
            .zip(values)
            .map(|(w, z)| z * C64::from_polar(self.noise[m].recip(), w * self.middles[m]))
            .collect();
        (0..values.len())
            .map(|i| self.whitener.row(i)[..=i].iter().zip(&turned).map(|(a, b)| *a * b).sum())
            .collect()
    }
}

/// Makes spectra in windows of one shape.
pub(crate) struct Windowed<'a> {
    located: &'a Located,
    options: &'a ClickOptions,
    frequencies: Vec<f64>,
    noise: Vec<f64>,
    whitener: Matrix,
    noise_known: bool,
}

impl<'a> Windowed<'a> {
    pub(crate) fn new(located: &'a Located, options: &'a ClickOptions) -> Self {
        let length = options.flat.0 + options.flat.1 + 2.0 * options.edge;
        let top = options.band_hz.1.min(0.45 * located.rate_hz);
        let frequencies: Vec<f64> = (1..)
            .map(|k| f64::from(k) / length)
            .take_while(|&f| f <= top)
            .filter(|&f| f >= options.band_hz.0)
            .map(|f| TAU * f)
            .collect();
        let mut windowed = Self {
            located,
            options,
            frequencies,
            noise: Vec::new(),
            whitener: Matrix::default(),
            noise_known: false,
        };
        windowed.learn_noise();
        windowed
    }

    pub(crate) fn spectra(&self, times: &[f64]) -> Spectra {
        let values = times.iter().enumerate().map(|(m, &t)| self.spectrum(m, t)).collect();
        let shift = 0.5 * (self.options.flat.1 - self.options.flat.0);
        Spectra {
            frequencies: self.frequencies.clone(),
            values,
            middles: times.iter().map(|t| t + shift).collect(),
            noise_known: self.noise_known,
            noise: self.noise.clone(),
            whitener: self.whitener.clone(),
        }
    }

    /// Spectrum of channel `m` in the window around time `centre`; phases count from the trigger.
    fn spectrum(&self, m: usize, centre: f64) -> Vec<C64> {
        let z = &self.located.channels[m];
        let step = 1.0 / self.located.rate_hz;
        let origin = (self.located.begin as f64 - self.located.quiet as f64) * step;
        let first =
            ((centre - self.options.flat.0 - self.options.edge - origin) / step).ceil().max(0.0) as usize;
        let last =
            ((centre + self.options.flat.1 + self.options.edge - origin) / step).floor().max(0.0) as usize;
        let last = last.min(z.len() - 1);
        let turns: Vec<C64> = self.frequencies.iter().map(|w| C64::from_polar(1.0, -w * step)).collect();
        let begin = origin + first as f64 * step;
        let mut phasors: Vec<C64> =
            self.frequencies.iter().map(|w| C64::from_polar(1.0, -w * begin)).collect();
        let mut sums = vec![C64::ZERO; phasors.len()];
        for n in first..=last.max(first) {
            let t = origin + n as f64 * step;
            let value = z[n] * self.taper(t - centre);
            for ((sum, phasor), turn) in sums.iter_mut().zip(&mut phasors).zip(&turns) {
                *sum += *phasor * value;
                *phasor *= turn;
            }
        }
        sums
    }

    fn taper(&self, t: f64) -> f64 {
        let beyond = (-t - self.options.flat.0).max(t - self.options.flat.1).max(0.0) / self.options.edge;
        if beyond >= 1.0 { 0.0 } else { 0.5 * (1.0 + (PI * beyond).cos()) }
    }

    /// Power of the noise in each channel and its shape over frequency, from windows in the quiet part. Neighbouring
    /// frequencies are correlated by the taper; that follows from its shape.
    fn learn_noise(&mut self) {
        let (channels, bins) = (self.located.channels.len(), self.frequencies.len());
        let length = self.options.flat.0 + self.options.flat.1 + 2.0 * self.options.edge;
        let start = (self.located.begin as f64 - self.located.quiet as f64) / self.located.rate_hz
            + self.options.flat.0
            + self.options.edge;
        // The high-pass filter reaches ahead into the impulse by twice its half length.
        let end = -2.0 * SMOOTHING - self.options.flat.1 - self.options.edge;
        let count = ((end - start) / (0.5 * length)).floor().max(-1.0) as i64 + 1;
        let mut power = vec![vec![0.0; bins]; channels];
        for (m, power) in power.iter_mut().enumerate() {
            for j in 0..count {
                let spectrum = self.spectrum(m, start + 0.5 * length * j as f64);
                for (p, z) in power.iter_mut().zip(spectrum) {
                    *p += 0.5 * z.norm_sqr() / count as f64;
                }
            }
        }
        let per_channel: Vec<f64> = power.iter().map(|p| p.iter().sum::<f64>() / bins as f64).collect();
        self.noise_known = count >= 4 && per_channel.iter().all(|&p| p > 0.0);
        // Without a quiet part the noise counts as equal, of unit size; residuals scale the covariance in the end.
        let size = |&p: &f64| if self.noise_known { p.sqrt() } else { 1.0 };
        self.noise = per_channel.iter().map(size).collect();
        let shape: Vec<f64> = (0..bins)
            .map(|k| {
                if !self.noise_known || self.options.weighting == Weighting::Flat {
                    return 1.0;
                }
                power.iter().zip(&per_channel).map(|(p, all)| p[k] / all).sum::<f64>() / channels as f64
            })
            .collect();
        self.whitener = self.between_frequencies(&shape, length);
    }

    /// Inverse Cholesky factor of the covariance between frequencies: the transform of the squared window, which is
    /// real for phases that count from its middle.
    fn between_frequencies(&self, shape: &[f64], length: f64) -> Matrix {
        let bins = shape.len();
        let correlation = |distance: usize| -> f64 {
            let samples = 400;
            let (mut sum, mut weight) = (0.0, 0.0);
            for n in 0..samples {
                let t = length * ((f64::from(n) + 0.5) / f64::from(samples) - 0.5);
                let h = self.taper(t + 0.5 * (self.options.flat.1 - self.options.flat.0)).powi(2);
                sum += h * (TAU * distance as f64 * t / length).cos();
                weight += h;
            }
            sum / weight
        };
        let table: Vec<f64> = (0..bins).map(correlation).collect();
        let covariance =
            Matrix::from_fn(bins, bins, |i, j| (shape[i] * shape[j]).sqrt() * table[i.abs_diff(j)]);
        match Cholesky::new(&covariance) {
            Ok(factor) => invert_lower(factor.lower()),
            // Only a window without samples has no such factor.
            Err(_) => Matrix::identity(bins),
        }
    }
}
