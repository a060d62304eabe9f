//! Gains and delays of microphones that hear the same pressure.
//!
//! Channel m holds g_m p(t - d_m) and noise of its own. In the ratio of cross spectra S_km/S_kr over a third
//! channel k the noise of m and of the reference r is on the average absent (channels at one place: Sleeman,
//! van Wettum & Trampert, Bull. Seism. Soc. Am. 96 (2006) 258), and its logarithm is the straight line
//! ln(g_m/g_r) - i 2 pi f (d_m - d_r).

use super::spectra::Spectra;
use super::switched::SHARED;
use crate::Fault;
use rijke_numerics::C64;
use rijke_rig::StatedChannels;
use std::f64::consts::TAU;

/// What a comparison tells of the channels.
#[derive(Clone, Debug, PartialEq)]
pub struct ComparedChannels {
    /// Gains and delays over those of the reference, whose own are 1 and 0 s. Errors of different channels
    /// are independent; that of the reference is what all others share. Nothing is known of a silent channel:
    /// its error is as large as such an error can be.
    pub channels: StatedChannels,
    /// Least coherence with the reference of each channel, mean over the band; 0 of a silent one.
    pub coherence: Vec<f64>,
    /// How far the gain of each channel goes from its mean over the band, relative to it, beyond the noise.
    pub bend: Vec<f64>,
    /// Channels that gave nothing.
    pub silent: Vec<usize>,
}

/// Why records do not compare channels.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ComparisonFault {
    /// A record cannot be used.
    #[error("record {file}: {fault}")]
    Record {
        /// Its number in the list, from 0.
        file: usize,
        /// Why.
        fault: Fault,
    },
    /// Two channels do not hear one sound.
    #[error(
        "channel {channel} and the reference do not measure the same sound: their coherence is {coherence:.2} on average, and 0.5 is needed"
    )]
    Incoherent {
        /// The channel.
        channel: usize,
        /// Mean of its coherence with the reference.
        coherence: f64,
    },
    /// A channel whose sign is not the same in all records.
    #[error("channel {channel} has another sign in record {file} than in the first")]
    Turned {
        /// The channel.
        channel: usize,
        /// Number of that record in the list, from 0.
        file: usize,
    },
    /// Nothing to compare with.
    #[error("{what}")]
    Alone {
        /// What is missing.
        what: &'static str,
    },
}

/// Least frequencies in the band, and least averages of each.
const FREQUENCIES: f64 = 24.0;
const AVERAGES: f64 = 8.0;
/// Mean coherence below which channels do not hear the same.
const COHERENT: f64 = 0.5;
/// Errors of a silent channel: 100 % of the gain, 1 ms of delay.
const UNKNOWN: [f64; 2] = [1.0, 1e-3];

impl ComparedChannels {
    /// From `records` (channels of equal length, at `rate_hz`) in which all channels hear the same pressure
    /// between the frequencies `band_hz`. `unequal`: standard deviations of what makes pressures at the
    /// microphones unequal all the same, relative, and in s.
    ///
    /// Cost: a Fourier transform of every record.
    ///
    /// # Errors
    /// [`ComparisonFault`].
    pub fn new(
        records: &[Vec<Vec<f64>>],
        rate_hz: f64,
        band_hz: [f64; 2],
        reference: usize,
        unequal: [f64; 2],
    ) -> Result<Self, ComparisonFault> {
        let count = records.first().map_or(0, Vec::len);
        let still = |c: usize| records.iter().all(|r| r.get(c).is_some_and(|y| y.iter().all(|v| *v == y[0])));
        let (silent, live): (Vec<usize>, Vec<usize>) = (0..count).partition(|c| still(*c));
        let Some(r) = live.iter().position(|c| *c == reference).filter(|_| live.len() > 1) else {
            let what = "the reference and one more microphone must give a signal";
            return Err(ComparisonFault::Alone { what });
        };
        let spacing = (0.5 * band_hz[0]).min((band_hz[1] - band_hz[0]) / FREQUENCIES);
        let segment = ((rate_hz / spacing).ceil() as usize).next_power_of_two();
        let mut of_records = Vec::with_capacity(records.len());
        for (file, record) in records.iter().enumerate() {
            let wrong = |fault: Fault| ComparisonFault::Record { file, fault: fault.within(&live) };
            let channels: Vec<Vec<f64>> = live.iter().filter_map(|c| record.get(*c).cloned()).collect();
            let spectra = Spectra::welch(&channels, rate_hz, segment, band_hz).map_err(wrong)?;
            if spectra.averages < AVERAGES {
                let (have, need) = (channels[0].len(), segment * (0.5 * (AVERAGES + 2.0)) as usize);
                return Err(wrong(Fault::TooShort { what: "record of the comparison", have, need }));
            }
            let own = Lines::of(&spectra, r)
                .map_err(|(m, coherence)| ComparisonFault::Incoherent { channel: live[m], coherence })?;
            let turned = |(a, b): (&Line, &Line)| a.sign * b.sign < 0.0;
            let first: &Lines = of_records.first().unwrap_or(&own);
            if let Some(m) = first.lines.iter().zip(&own.lines).position(turned) {
                return Err(ComparisonFault::Turned { channel: live[m], file });
            }
            of_records.push(own);
        }
        let all = Lines::mean(&of_records);
        let shared = all.of_reference();
        let mut found = Self {
            channels: StatedChannels {
                gains: vec![1.0; count],
                gain_sds: vec![UNKNOWN[0]; count],
                delays: vec![0.0; count],
                delay_sds: vec![UNKNOWN[1]; count],
            },
            coherence: vec![0.0; count],
            bend: vec![0.0; count],
            silent,
        };
        for (line, &c) in all.lines.iter().zip(&live) {
            let own = |k: usize| {
                let variance = if c == reference { shared[k] } else { line.variance[k] - shared[k] };
                (variance.max(0.0) + unequal[k].powi(2)).sqrt()
            };
            found.channels.gains[c] = line.sign * line.value[0].exp();
            found.channels.delays[c] = line.value[1];
            (found.channels.gain_sds[c], found.channels.delay_sds[c]) =
                (own(0).clamp(1e-9, UNKNOWN[0]), own(1).clamp(1e-12, UNKNOWN[1]));
            (found.coherence[c], found.bend[c]) = (line.coherence, line.bend);
        }
        Ok(found)
    }
}

/// The gain of a channel over that of the reference, by the line that is its logarithm over frequency.
#[derive(Clone, Copy)]
struct Line {
    /// Logarithm of the modulus of the gain, and delay, s.
    value: [f64; 2],
    /// Their variances.
    variance: [f64; 2],
    /// Of the gain.
    sign: f64,
    coherence: f64,
    /// How much of the variance is the reference's, 0 to 1.
    share: f64,
    bend: f64,
}

/// Those of all channels.
struct Lines {
    lines: Vec<Line>,
    reference: usize,
}

impl Lines {
    /// Of the channels of one record; where one does not hear the reference, that channel and its coherence.
    fn of(spectra: &Spectra, reference: usize) -> Result<Self, (usize, f64)> {
        let n = spectra.cross.first().map_or(0, Vec::len);
        // ln(1 + noise over signal) of a pair of channels is the sum of that of either.
        let noise = |a: usize, b: usize| {
            let all = spectra.transfer(a, b);
            all.iter().map(|h| -h.coherence.max(f64::MIN_POSITIVE).ln()).sum::<f64>()
                / all.len().max(1) as f64
        };
        let one = |m: usize| {
            let alone = Line {
                value: [0.0; 2],
                variance: [0.0; 2],
                sign: 1.0,
                coherence: 1.0,
                share: 1.0,
                bend: 0.0,
            };
            if m == reference {
                return Ok(alone);
            }
            let transfers = spectra.transfer(reference, m);
            let coherence =
                transfers.iter().map(|h| h.coherence).sum::<f64>() / transfers.len().max(1) as f64;
            if coherence < COHERENT {
                return Err((m, coherence));
            }
            let third: Vec<usize> = (0..n).filter(|k| *k != m && *k != reference).collect();
            let ratio = |(sums, h): (&Vec<Vec<C64>>, &super::TransferEstimate)| {
                if third.is_empty() {
                    return h.even();
                }
                let weight: f64 = third.iter().map(|k| sums[*k][reference].norm_sqr()).sum();
                third.iter().map(|k| sums[*k][reference].conj() * sums[*k][m]).sum::<C64>() / weight
            };
            let ratios: Vec<C64> = spectra.cross.iter().zip(&transfers).map(ratio).collect();
            let sds: Vec<f64> = transfers.iter().map(|h| h.relative_sd).collect();
            let mut line = fitted(&spectra.frequency_hz, &ratios, &sds);
            line.coherence = coherence;
            let pair = noise(reference, m);
            if third.is_empty() {
                // Which of the two has the noise is not known, and the ratio leans by the half of its
                // difference.
                (line.share, line.variance[0]) = (0.5, line.variance[0] + (0.5 * pair).powi(2));
            } else {
                let of = |k: &usize| 0.5 * (pair + noise(reference, *k) - noise(*k, m));
                let own = third.iter().map(of).sum::<f64>() / third.len() as f64;
                line.share = (own / pair.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            }
            Ok(line)
        };
        Ok(Self { lines: (0..n).map(one).collect::<Result<_, _>>()?, reference })
    }

    /// The mean of several records. What scatters between them beyond their errors, because microphones were
    /// put in place anew, is one variance for all channels (DerSimonian & Laird, Control. Clin. Trials 7
    /// (1986) 177, eq. 8).
    fn mean(records: &[Self]) -> Self {
        let (reference, count) = (records[0].reference, records[0].lines.len());
        let mut lines: Vec<Line> = records[0].lines.clone();
        let others: Vec<usize> = (0..count).filter(|m| *m != reference).collect();
        for k in 0..2 {
            // Value and variance by channel and record.
            let of = |m: usize| records.iter().map(move |r| (r.lines[m].value[k], r.lines[m].variance[k]));
            let mean = |m: usize, more: f64| {
                let weight: f64 = of(m).map(|(_, v)| (v + more).recip()).sum();
                (of(m).map(|(x, v)| x / (v + more)).sum::<f64>() / weight, weight.recip())
            };
            let (mut square, mut freedom, mut scale) = (0.0, 0.0, 0.0);
            for &m in &others {
                let weight: f64 = of(m).map(|(_, v)| v.recip()).sum();
                square += of(m).map(|(x, v)| (x - mean(m, 0.0).0).powi(2) / v).sum::<f64>();
                freedom += records.len() as f64 - 1.0;
                scale += weight - of(m).map(|(_, v)| v.powi(-2)).sum::<f64>() / weight;
            }
            let more = if freedom > 0.0 { ((square - freedom) / scale).max(0.0) } else { 0.0 };
            for &m in &others {
                (lines[m].value[k], lines[m].variance[k]) = mean(m, more);
            }
        }
        for (m, line) in lines.iter_mut().enumerate() {
            let of = |f: fn(&Line) -> f64| records.iter().map(move |r| f(&r.lines[m]));
            line.coherence = of(|l| l.coherence).fold(1.0, f64::min);
            line.bend = of(|l| l.bend).sum::<f64>() / records.len() as f64;
            line.share = of(|l| l.share).sum::<f64>() / records.len() as f64;
            if line.bend > 0.0 {
                // At one frequency of the band the gain lies as far from the mean as it bends.
                line.variance[0] += line.bend.powi(2);
            }
        }
        Self { lines, reference }
    }

    /// The part of the variances that the reference gives to all channels.
    fn of_reference(&self) -> [f64; 2] {
        let others = || self.lines.iter().enumerate().filter(|(m, _)| *m != self.reference);
        [0, 1].map(|k| others().map(|(_, line)| line.share * line.variance[k]).fold(f64::INFINITY, f64::min))
    }
}

/// Fits ln g - i 2 pi f d to ratios whose logarithms have the standard deviations `sds` in either part.
fn fitted(frequency_hz: &[f64], ratios: &[C64], sds: &[f64]) -> Line {
    let low = frequency_hz.len().div_ceil(4);
    let sign = if ratios[..low].iter().map(|h| h.re).sum::<f64>() < 0.0 { -1.0 } else { 1.0 };
    let mut before = 0.0;
    let logarithms: Vec<C64> = ratios
        .iter()
        .map(|h| {
            let log = (sign * h).ln();
            let turns = ((before - log.im) / TAU).round();
            before = log.im + TAU * turns;
            C64::new(log.re, before)
        })
        .collect();
    let rows =
        || frequency_hz.iter().zip(&logarithms).zip(sds).map(|((f, l), sd)| (-TAU * f, *l, sd.powi(-2)));
    let sum = |of: &dyn Fn(f64, C64, f64) -> f64| rows().map(|(x, l, w)| of(x, l, w)).sum::<f64>();
    let (all, squares) = (sum(&|_, _, w| w), sum(&|x, _, w| w * x * x));
    let value = [sum(&|_, l, w| w * l.re) / all, sum(&|x, l, w| w * x * l.im) / squares];
    let freedom = (frequency_hz.len() as f64 - 1.0).max(1.0);
    let chi = [
        sum(&|_, l, w| w * (l.re - value[0]).powi(2)) / freedom,
        sum(&|x, l, w| w * (l.im - x * value[1]).powi(2)) / freedom,
    ];
    let variance = [SHARED * chi[0].max(1.0) / all, SHARED * chi[1].max(1.0) / squares];
    // Twice what the noise makes of it is no chance: sums of two dozen squares scatter by a third.
    let bend =
        if chi[0] > 2.0 { (chi[0] - 1.0).sqrt() / (all / frequency_hz.len() as f64).sqrt() } else { 0.0 };
    Line { value, variance, sign, coherence: 1.0, share: 0.5, bend }
}
