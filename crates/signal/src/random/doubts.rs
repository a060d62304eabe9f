//! What is wrong with records of channels that changed places, where their estimates of the gains disagree:
//! exchanged files, exchanged channels, or a channel that is inverted in one of them.

use super::spectra::Spectra;
use super::switched::SwitchedGains;
use std::f64::consts::FRAC_PI_2;

/// Why the estimates of the gains disagree. Record 0 is the straight one, record c that in which channels 0
/// and c have changed places.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SwitchedFault {
    /// Two records stand for one another.
    Records([usize; 2]),
    /// Two channels of a record stand for one another.
    Channels {
        /// The record.
        record: usize,
        /// The channels.
        channels: [usize; 2],
    },
    /// A channel is inverted in one record.
    Inverted {
        /// The record; none if it may be any.
        record: Option<usize>,
        /// The channel.
        channel: usize,
    },
}

/// A fault of records, and what undoing it changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SwitchedDoubt {
    /// The fault.
    pub fault: SwitchedFault,
    /// Root mean square of the distances of the estimates from the gains, relative to these: see
    /// [`super::GainPair`].
    pub before: f64,
    /// The same if the fault is undone.
    pub after: f64,
}

/// Distance of the estimates, relative to the gains, from which a fault is looked for, and the share of it
/// that undoing one must leave at most.
const UNLIKE: f64 = 0.1;
const LEFT: f64 = 0.25;
/// Factor of the least distance up to which faults explain the records equally well: then gains near 1
/// decide.
const AS_WELL: f64 = 1.5;
/// Distance of a phase from a right angle that tells of an inverted channel, rad.
const NEAR: f64 = 0.5;

impl SwitchedGains {
    /// Channels whose gain is nearer to -1 than to 1 over the whole band: their wires may be swapped.
    #[must_use]
    pub fn inverted(&self) -> Vec<usize> {
        let is_negative = |c: &usize| self.gains[*c].iter().all(|g| g.re < 0.0 && g.im.abs() < -g.re);
        (0..self.gains.len()).filter(is_negative).collect()
    }

    /// What is wrong with the records that gave these gains, if their estimates disagree and one fault
    /// explains it.
    #[must_use]
    pub fn doubt(
        &self,
        straight: &Spectra,
        switched: &[(usize, Spectra)],
        polynomials: usize,
    ) -> Option<SwitchedDoubt> {
        let channels = self.gains.len();
        let before = self.distance();
        if channels == 2 {
            // One estimate alone: the root of a product of two transfer functions that have the same sign.
            let turned = self.gains[1].iter().filter(|g| (g.arg().abs() - FRAC_PI_2).abs() < NEAR).count();
            let fault = SwitchedFault::Inverted { record: None, channel: 1 };
            let doubt = SwitchedDoubt { fault, before, after: before };
            return (2 * turned > self.gains[1].len()).then_some(doubt);
        }
        // Standard deviations say nothing here: they grow with what the polynomials leave.
        if before < UNLIKE {
            return None;
        }
        // Record number k of `all`; those of one number stand together.
        let all: Vec<&Spectra> =
            (0..channels)
                .map(|c| {
                    if c == 0 { Some(straight) } else { switched.iter().find(|(k, _)| *k == c).map(|s| &s.1) }
                })
                .collect::<Option<_>>()?;
        let mut found: Vec<(SwitchedDoubt, f64)> = Vec::new();
        for fault in faults(channels) {
            let mut mended: Vec<Spectra> = all.iter().map(|s| (*s).clone()).collect();
            match fault {
                SwitchedFault::Records([a, b]) => mended.swap(a, b),
                SwitchedFault::Channels { record, channels: [a, b] } => {
                    mended[record] = all[record].exchanged(a, b)
                }
                SwitchedFault::Inverted { record, channel } => {
                    let record = record.unwrap_or(0);
                    mended[record] = all[record].inverted(channel);
                }
            }
            let straight = mended.remove(0);
            let switched: Vec<(usize, Spectra)> =
                mended.into_iter().enumerate().map(|(k, spectra)| (k + 1, spectra)).collect();
            let Ok(gains) = Self::new(&straight, &switched, channels, polynomials) else { continue };
            let after = gains.distance();
            if after < LEFT * before {
                found.push((SwitchedDoubt { fault, before, after }, gains.likeness()));
            }
        }
        let least = found.iter().map(|(doubt, _)| doubt.after).fold(f64::INFINITY, f64::min);
        let likely = found.into_iter().filter(|(doubt, _)| doubt.after <= AS_WELL * least);
        likely.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(doubt, _)| doubt)
    }

    /// Root mean square of the distances of the estimates.
    fn distance(&self) -> f64 {
        let square: f64 = self.pairs.iter().map(|p| p.distance * p.distance).sum();
        (square / self.pairs.len().max(1) as f64).sqrt()
    }

    /// How near the gains are to 1: the mean of the cosine of their phase, less the root mean square of their
    /// logarithm's size.
    fn likeness(&self) -> f64 {
        let all = || self.gains.iter().skip(1).flatten();
        let count = all().count().max(1) as f64;
        let cosine = all().map(|g| g.re / g.norm()).sum::<f64>() / count;
        cosine - (all().map(|g| g.norm().ln().powi(2)).sum::<f64>() / count).sqrt()
    }
}

/// Every single fault that records of so many channels may have.
fn faults(channels: usize) -> Vec<SwitchedFault> {
    let pairs = || (0..channels).flat_map(move |a| (a + 1..channels).map(move |b| [a, b]));
    let mut all: Vec<SwitchedFault> = pairs().map(SwitchedFault::Records).collect();
    for record in 0..channels {
        let inverted = |channel| SwitchedFault::Inverted { record: Some(record), channel };
        all.extend((0..channels).map(inverted));
        all.extend(pairs().map(|channels| SwitchedFault::Channels { record, channels }));
    }
    all
}
