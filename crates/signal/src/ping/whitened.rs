//! A record in white samples, and what its envelope shows: what every way to find the decay begins with.

use super::forcing::Envelope;
use super::options::PingOptions;
use super::ringing::{self, Ringing};
use super::search::Search;
use crate::dsp::noise::Whitener;
use crate::ringdown::White;
use crate::{Fault, Trace};

/// What is known of the noise before a fit.
pub(super) struct Noise {
    pub(super) whitener: Whitener,
    /// Harmonics of the mains that the record holds.
    pub(super) harmonics: Vec<u32>,
    /// Steady tones beside the mode that it holds, Hz.
    pub(super) tones: Vec<f64>,
    /// The quiet part without them; nothing if it is too short.
    pub(super) silence: Vec<Vec<f64>>,
    /// The frequency at which it rings, Hz.
    pub(super) narrow_hz: Option<f64>,
}

impl Noise {
    pub(super) fn of(whitener: Whitener, harmonics: Vec<u32>) -> Self {
        Self { whitener, harmonics, tones: Vec::new(), silence: Vec::new(), narrow_hz: None }
    }
}

/// A record after its quiet part, white.
pub(super) struct Whitened<'a> {
    pub(super) noise: &'a Noise,
    samples: Vec<f64>,
    /// The quiet part, white.
    pub(super) silence: Vec<f64>,
    pub(super) envelope: Envelope,
    pub(super) ringing: Ringing,
    channels: usize,
    step: f64,
}

impl<'a> Whitened<'a> {
    pub(super) fn of(trace: &Trace<'_>, options: &PingOptions, noise: &'a Noise) -> Result<Self, Fault> {
        let (channels, step) = (trace.channels.len(), 1.0 / trace.rate_hz);
        let quiet = trace.quiet.min(trace.len());
        let samples = noise.whitener.apply(trace.channels, quiet, trace.len());
        let mut envelope = Envelope::new(White { samples: &samples, channels, step }, options.band_hz)?;
        let length = noise.silence.first().map_or(0, Vec::len);
        let silence = noise.whitener.apply(&noise.silence, 0, length);
        let quietness = White { samples: &silence, channels, step };
        let power = noise.narrow_hz.map_or(0.0, |hz| ringing::power_at(quietness, hz));
        let ringing = if power > 0.0 { envelope.ringing(power, step) } else { Ringing::default() };
        Ok(Self { noise, samples, silence, envelope, ringing, channels, step })
    }

    pub(super) fn white(&self) -> White<'_> {
        White { samples: &self.samples, channels: self.channels, step: self.step }
    }

    pub(super) fn quietness(&self) -> White<'_> {
        White { samples: &self.silence, channels: self.channels, step: self.step }
    }

    pub(super) fn search<'b>(&'b self, options: &'b PingOptions) -> Search<'b> {
        let Noise { harmonics, tones, .. } = self.noise;
        Search { options, harmonics, tones, ringing: self.ringing }
    }
}
