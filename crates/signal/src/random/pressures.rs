//! Pressures at microphones over that at the first, with the gains of the channels undone.

use super::one_source::OneSource;
use super::spectra::Spectra;
use super::swept::Swept;
use super::switched::SwitchedGains;
use rijke_numerics::C64;
use rijke_rig::StatedChannels;
use std::f64::consts::TAU;

/// Gains of the channels.
#[derive(Clone, Debug, PartialEq)]
pub enum ChannelGains {
    /// From records in which channels changed places.
    Switched(SwitchedGains),
    /// As a manifest states them.
    Stated(StatedChannels),
    /// Nothing is known of them: all are taken for 1, without error.
    Equal,
}

/// Pressures over that at the first microphone.
#[derive(Clone, Debug, PartialEq)]
pub struct RelativePressures {
    /// Frequencies, Hz.
    pub frequency_hz: Vec<f64>,
    /// By frequency and microphone.
    pub pressures: Vec<Vec<C64>>,
    /// Standard deviations of the real and of the imaginary part of the logarithms, that of the gains
    /// included, by frequency and microphone.
    pub relative_sd: Vec<Vec<f64>>,
    /// Frequencies that were left out, because their coherence was too small.
    pub left_out: usize,
    /// The share of the power of each microphone that is the sound which all have in common, median over the
    /// frequencies; 1 of one or two microphones, which do not tell it.
    pub of_the_source: Vec<f64>,
}

/// Why sweeps give no pressures.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PressureFault {
    /// The frequencies of the gains are others.
    #[error("not as long as the records of `straight`")]
    OtherLength,
    /// No frequency is good enough.
    #[error("no frequency has a coherence of {wanted}")]
    Incoherent {
        /// The coherence that was asked for.
        wanted: f64,
    },
}

impl ChannelGains {
    /// The gain of channel `c` at frequency `hz`, the `k`-th, and the standard deviation of each part of its
    /// logarithm.
    #[must_use]
    pub fn at(&self, c: usize, k: usize, hz: f64) -> (C64, f64) {
        match self {
            Self::Switched(gains) => (gains.gains[c][k], gains.relative_sd[c][k]),
            Self::Stated(s) => {
                let gain = C64::from_polar(s.gains[c], -TAU * hz * s.delays[c]);
                (gain, s.gain_sds[c].hypot(TAU * hz * s.delay_sds[c]))
            }
            Self::Equal => (C64::ONE, 0.0),
        }
    }
}

/// Every second frequency of Welch's spectra is taken: errors of neighbours correlate by 4/9 under Hann's
/// window, those of every second one by 1/36.
const APART: usize = 2;

impl RelativePressures {
    /// Of random noise at `microphones` channels: of three or more as one source makes them (factor analysis
    /// with one factor), of two by the root of the ratio of their spectra.
    #[must_use]
    pub fn of_noise(found: Spectra, microphones: usize, gains: &ChannelGains) -> Self {
        let heard = OneSource::of(&found, microphones);
        let row = |(k, (heard, sds)): (usize, (&Vec<C64>, &Vec<f64>))| {
            let own = heard.iter().copied().zip(sds.iter().copied());
            over_the_first(own, gains, (k, found.frequency_hz[k]))
        };
        let all = heard.pressures.iter().zip(&heard.relative_sd).enumerate();
        let (pressures, relative_sd) = all.step_by(APART).map(row).unzip();
        let of_the_source = heard.shares(&Vec::from_iter(0..found.frequency_hz.len()));
        let frequency_hz = found.frequency_hz.iter().copied().step_by(APART).collect();
        Self { frequency_hz, pressures, relative_sd, left_out: 0, of_the_source }
    }

    /// Of sweeps and periodic sounds, at the frequencies whose coherence is at least `coherence`.
    ///
    /// # Errors
    /// [`PressureFault`].
    pub fn of_sweeps(found: &Swept, coherence: f64, gains: &ChannelGains) -> Result<Self, PressureFault> {
        let all = &found.spectra.frequency_hz;
        if let ChannelGains::Switched(gains) = gains
            && gains.frequency_hz != *all
        {
            return Err(PressureFault::OtherLength);
        }
        let used: Vec<usize> = (0..all.len()).filter(|k| found.fields[*k].coherence >= coherence).collect();
        if used.is_empty() {
            return Err(PressureFault::Incoherent { wanted: coherence });
        }
        let row = |&k: &usize| {
            let field = &found.fields[k];
            let own = field.pressures.iter().map(|p| (*p, field.sd / p.norm()));
            over_the_first(own, gains, (k, all[k]))
        };
        let (pressures, relative_sd) = used.iter().map(row).unzip();
        let left_out = all.len() - used.len();
        let frequency_hz = used.iter().map(|&k| all[k]).collect();
        let microphones = found.fields.first().map_or(0, |field| field.pressures.len());
        let of_the_source = OneSource::of(&found.spectra, microphones).shares(&used);
        Ok(Self { frequency_hz, pressures, relative_sd, left_out, of_the_source })
    }

    /// The median of all relative standard deviations but those that are nothing.
    #[must_use]
    pub fn median_sd(&self) -> f64 {
        let mut sds: Vec<f64> = self.relative_sd.iter().flatten().copied().filter(|sd| *sd > 0.0).collect();
        sds.sort_by(f64::total_cmp);
        sds.get(sds.len() / 2).copied().unwrap_or(f64::NAN)
    }
}

/// Pressures over the first one, with the gains undone, and their standard deviations; of pressures with
/// their own, at the frequency `hz`, the `k`-th.
fn over_the_first(
    heard: impl Iterator<Item = (C64, f64)>,
    gains: &ChannelGains,
    (k, hz): (usize, f64),
) -> (Vec<C64>, Vec<f64>) {
    let undone = heard.enumerate().map(|(c, (p, sd))| {
        let (gain, gain_sd) = gains.at(c, k, hz);
        (p / gain, sd.hypot(gain_sd))
    });
    let (all, sds): (Vec<C64>, Vec<f64>) = undone.unzip();
    let first = all.first().copied().unwrap_or(C64::ONE);
    (all.into_iter().map(|p| p / first).collect(), sds)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Field, SweptOptions};

    /// Two microphones at two frequencies, the first of which is incoherent.
    fn swept() -> Swept {
        let records: Vec<Vec<Vec<f64>>> = (0..2)
            .map(|r| {
                (0..2).map(|c| (0..4096).map(|t| f64::from((t * (7 + c) + r) % 11) - 5.0).collect()).collect()
            })
            .collect();
        let options = SweptOptions { band_hz: [100.0, 400.0], resolution_hz: 150.0, period: None };
        let mut found = Swept::new(&records, 1000.0, &options).unwrap();
        let count = found.spectra.frequency_hz.len();
        found.fields = (0..count)
            .map(|k| Field {
                pressures: vec![C64::new(0.6, 0.0), C64::new(0.0, 0.8)],
                sd: 0.006,
                coherence: if k == 0 { 0.5 } else { 0.99 },
            })
            .collect();
        found
    }

    #[test]
    fn exact_gains_and_delays_are_undone() {
        let found = swept();
        let hz = found.spectra.frequency_hz.clone();
        let stated = StatedChannels {
            gains: vec![2.0, 0.5],
            gain_sds: vec![0.0, 0.03],
            delays: vec![0.0, 1e-4],
            delay_sds: vec![0.0, 0.0],
        };
        let heard = RelativePressures::of_sweeps(&found, 0.9, &ChannelGains::Stated(stated)).unwrap();
        assert_eq!((heard.left_out, &heard.frequency_hz[..]), (1, &hz[1..]));
        for (k, f) in heard.frequency_hz.iter().enumerate() {
            let truth = C64::new(0.0, 0.8 / 0.6) * 4.0 * C64::from_polar(1.0, TAU * f * 1e-4);
            assert!((heard.pressures[k][1] - truth).norm() < 1e-12, "{}", heard.pressures[k][1]);
            assert!((heard.pressures[k][0] - 1.0).norm() < 1e-12);
            assert!((heard.relative_sd[k][1] - (0.006_f64 / 0.8).hypot(0.03)).abs() < 1e-12);
        }
        assert_eq!(
            RelativePressures::of_sweeps(&found, 1.1, &ChannelGains::Equal),
            Err(PressureFault::Incoherent { wanted: 1.1 })
        );
    }
}
