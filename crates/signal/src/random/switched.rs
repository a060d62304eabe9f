//! Gains of channels from records in which two of them have changed places in the same sound field.
//!
//! With p_m the pressure at place m and g_c the gain of channel c, channel m over channel 0 is g_m p_m/(g_0
//! p_0) with every channel at its own place. Where channels 0 and c have changed places, channel c over
//! channel 0 is g_c p_0/(g_0 p_c), and channel m over channel c is g_m p_m/(g_c p_0). So the gain of channel
//! c over that of channel 0 follows from every other channel m once, as the ratio of two transfer functions,
//! and from its own as the root of their product. They agree as far as the sound field was the same.

use super::spectra::{Spectra, TransferEstimate};
use crate::Fault;
use rijke_numerics::{C64, Cholesky, Matrix, special};
use std::f64::consts::PI;

/// Gains of the channels over that of channel 0.
#[derive(Clone, Debug, PartialEq)]
pub struct SwitchedGains {
    /// Frequencies, Hz.
    pub frequency_hz: Vec<f64>,
    /// By channel and frequency.
    pub gains: Vec<Vec<C64>>,
    /// Standard deviation of the real and of the imaginary part of their logarithms, by channel and
    /// frequency.
    pub relative_sd: Vec<Vec<f64>>,
    /// How far every estimate is from the gain that all of them make.
    pub pairs: Vec<GainPair>,
}

/// One estimate of the gain of a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GainPair {
    /// The channel.
    pub channel: usize,
    /// The channel by which it was compared with channel 0: itself, where it was heard at both places.
    pub by: usize,
    /// Distance from the gain, relative to it, root mean square over the band.
    pub distance: f64,
    /// The standard deviation that it should have, in the same mean.
    pub sd: f64,
}

/// Neighbouring frequencies of spectra with Hann's window share their noise: so many of them are worth one in
/// a mean over a band.
///
/// A mean over all frequencies and segments is one over time, weighted by the sum of the squared windows.
/// Half over each other, Hann's make a weight that swings about its mean by a third: 18/19 of the time T
/// count, and T B 18/19 numbers in a band B are independent. Welch's equation counts 2 T B/(1 + 1/18) of
/// them.
pub(super) const SHARED: f64 = 2.0;

impl SwitchedGains {
    /// From a record with every channel at its own place, and one for every channel but 0 that changed places
    /// with channel 0. The logarithm of a gain is a sum of so many Legendre polynomials of frequency, fitted
    /// with the weights that coherence gives.
    ///
    /// # Errors
    /// [`Fault::TooShort`] for less frequencies than two for each polynomial, or a channel without a record.
    pub fn new(
        straight: &Spectra,
        switched: &[(usize, Spectra)],
        channels: usize,
        polynomials: usize,
    ) -> Result<Self, Fault> {
        let frequency_hz = straight.frequency_hz.clone();
        let n = frequency_hz.len();
        let same = |s: &Spectra| s.frequency_hz == frequency_hz;
        if n < 2 * polynomials || !switched.iter().all(|(_, s)| same(s)) {
            return Err(Fault::TooShort { what: "band", have: n, need: 2 * polynomials });
        }
        let basis = self::polynomials(&frequency_hz, polynomials);
        let mut all = Self {
            gains: vec![vec![C64::ONE; n]],
            relative_sd: vec![vec![0.0; n]],
            frequency_hz,
            pairs: Vec::new(),
        };
        for c in 1..channels {
            let Some((_, record)) = switched.iter().find(|(channel, _)| *channel == c) else {
                return Err(Fault::TooShort {
                    what: "list of records with channels that changed places",
                    have: switched.len(),
                    need: channels - 1,
                });
            };
            let mut curves: Vec<(usize, Curve)> = Vec::new();
            for m in (1..channels).filter(|m| *m != c) {
                let (a, b) = (straight.transfer(0, m), record.transfer(c, m));
                let ratios: Vec<C64> = a.iter().zip(&b).map(|(a, b)| a.even() / b.even()).collect();
                let sds = a.iter().zip(&b).map(|(a, b)| a.relative_sd.hypot(b.relative_sd));
                curves.push((m, Curve::fitted(&basis, logarithms(&ratios).into_iter().zip(sds).collect())?));
            }
            let (a, b) = (straight.transfer(0, c), record.transfer(0, c));
            let near = mean(&curves);
            let products: Vec<C64> = a.iter().zip(&b).map(|(a, b)| a.even() * b.even()).collect();
            let roots = logarithms(&products);
            let product = |(k, (a, b)): (usize, (&TransferEstimate, &TransferEstimate))| {
                let root = 0.5 * roots[k];
                // The root has two values: the one next to what the others say.
                let turns = near.as_ref().map_or(0.0, |near| ((near.values[k] - root).im / PI).round());
                (root + C64::new(0.0, PI * turns), 0.5 * a.relative_sd.hypot(b.relative_sd))
            };
            let own = a.iter().zip(&b).enumerate().map(product).collect();
            curves.push((c, Curve::fitted(&basis, own)?));
            let Some(mut gain) = mean(&curves) else { continue };
            let distances: Vec<(f64, f64)> = curves
                .iter()
                .map(|(_, curve)| {
                    let square: f64 =
                        curve.values.iter().zip(&gain.values).map(|(a, b)| (a - b).norm_sqr()).sum();
                    ((square / n as f64).sqrt(), curve.size())
                })
                .collect();
            // Two parts of a complex number.
            let chi = distances.iter().map(|(d, sd)| 0.5 * (d / sd).powi(2)).sum::<f64>()
                / (distances.len() - 1).max(1) as f64;
            let wider = chi.max(1.0).sqrt();
            gain.sds.iter_mut().for_each(|sd| *sd *= wider);
            all.gains.push(gain.values.iter().map(|l| l.exp()).collect());
            all.relative_sd.push(gain.sds);
            for ((by, _), (distance, sd)) in curves.iter().zip(distances) {
                all.pairs.push(GainPair { channel: c, by: *by, distance, sd });
            }
        }
        Ok(all)
    }
}

/// Logarithms of numbers that belong together. Those of an inverted channel lie about -1, where the usual one
/// jumps.
fn logarithms(values: &[C64]) -> Vec<C64> {
    let middle: C64 = values.iter().map(|v| v / v.norm().max(f64::MIN_POSITIVE)).sum();
    let turned = |v: &C64| if middle.re < 0.0 { (-v).ln() + C64::new(0.0, PI) } else { v.ln() };
    values.iter().map(turned).collect()
}

/// The logarithm of a gain over frequency.
struct Curve {
    values: Vec<C64>,
    sds: Vec<f64>,
}

impl Curve {
    /// Fits polynomials to numbers with standard deviations; what scatters more than these makes the error
    /// larger.
    fn fitted(basis: &[Vec<f64>], data: Vec<(C64, f64)>) -> Result<Self, Fault> {
        let p = basis.first().map_or(0, Vec::len);
        let mut normal = Matrix::zeros(p, p);
        let mut right = [vec![0.0; p], vec![0.0; p]];
        for (row, (value, sd)) in basis.iter().zip(&data) {
            let weight = 1.0 / (sd * sd);
            for i in 0..p {
                right[0][i] += weight * row[i] * value.re;
                right[1][i] += weight * row[i] * value.im;
                for j in 0..p {
                    normal[(i, j)] += weight * row[i] * row[j];
                }
            }
        }
        let factor = Cholesky::new(&normal)?;
        let found = right.map(|r| factor.solve(&r));
        let at = |row: &Vec<f64>, c: &[f64]| row.iter().zip(c).map(|(b, c)| b * c).sum::<f64>();
        let values: Vec<C64> =
            basis.iter().map(|row| C64::new(at(row, &found[0]), at(row, &found[1]))).collect();
        let square: f64 =
            data.iter().zip(&values).map(|((value, sd), fit)| (value - fit).norm_sqr() / (sd * sd)).sum();
        let chi = (square / (2.0 * (data.len() - p).max(1) as f64)).max(1.0);
        let sd = |row: &Vec<f64>| (SHARED * chi * at(row, &factor.solve(row))).sqrt();
        Ok(Self { values, sds: basis.iter().map(sd).collect() })
    }

    /// Root mean square of the standard deviations.
    fn size(&self) -> f64 {
        (self.sds.iter().map(|sd| sd * sd).sum::<f64>() / self.sds.len().max(1) as f64).sqrt()
    }
}

/// The mean of several estimates, weighted by their errors. They share records, and so errors: the mean is
/// taken to be no better than they are.
fn mean(curves: &[(usize, Curve)]) -> Option<Curve> {
    let weights: Vec<f64> = curves.iter().map(|(_, c)| c.size().powi(-2)).collect();
    let (all, n) = (weights.iter().sum::<f64>(), curves.first()?.1.values.len());
    let sum = |k: usize| curves.iter().zip(&weights).map(|((_, c), w)| c.values[k] * *w).sum::<C64>() / all;
    let sd = |k: usize| curves.iter().zip(&weights).map(|((_, c), w)| c.sds[k] * w).sum::<f64>() / all;
    Some(Curve { values: (0..n).map(sum).collect(), sds: (0..n).map(sd).collect() })
}

/// The first `count` Legendre polynomials over the band, by frequency.
fn polynomials(frequency_hz: &[f64], count: usize) -> Vec<Vec<f64>> {
    let (low, high) = (frequency_hz[0], frequency_hz[frequency_hz.len() - 1]);
    let place = |f: &f64| 2.0 * (f - low) / (high - low) - 1.0;
    frequency_hz.iter().map(|f| special::legendre(place(f), count)).collect()
}
