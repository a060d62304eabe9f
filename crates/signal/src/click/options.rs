//! What the fit of a click may assume, and what it gives.

use crate::{Fault, Trace};
use rijke_numerics::{C64, Matrix};

/// What the fit may assume.
#[derive(Clone, Debug, PartialEq)]
pub struct ClickOptions {
    /// Frequencies that the impulse holds, Hz. For a tube the upper one stays below the cut-on of its first
    /// transverse mode.
    pub band_hz: (f64, f64),
    /// Nominal frequency of the mains, Hz: a record in which its hum is as loud as the impulse is refused.
    pub mains_hz: f64,
    /// How long before and after its peak the record is used, s. The impulse itself is zero in the last
    /// eighth at each end.
    pub window: (f64, f64),
    /// Dispersion kappa of the path to each channel, s^{1/2}: the path multiplies the spectrum with
    /// e^{-(1+i) kappa sqrt(omega)}. Empty for none. In a tube of radius a, with kinematic viscosity nu,
    /// kappa = x / (a c) sqrt(nu / 2) (1 + (gamma - 1) / sqrt(Pr)) (Kirchhoff 1868).
    pub dispersion: Vec<f64>,
    /// The first reflection, if there is one that may overlap the impulse.
    pub reflection: Option<Reflection>,
    /// Whether to say how far times and gains lean on what is not known of the end ([`ClickFit::leaning`]),
    /// as a calibration needs.
    pub leaning: bool,
}

/// What is known beforehand about the first reflection, such as that at the far end of a tube.
#[derive(Clone, Debug, PartialEq)]
pub struct Reflection {
    /// Lag behind the direct impulse at each channel, s.
    pub lags: Vec<f64>,
    /// Reflection coefficient at low frequency, -1 for an open end.
    pub strength: f64,
    /// Standard deviation of the Gaussian that smooths the impulse in the reflection, s. An open end of
    /// radius a reflects as 1 - (k a)^2 / 2 (Levine & Schwinger 1948): a / c.
    pub smoothing: f64,
    /// Standard deviation of each tap about that expectation, relative to `strength`.
    pub tolerance: f64,
    /// Relative standard deviation of the lags, which have one factor in common: 0 if the speed of sound
    /// between channels and end is known, some 0.2 if the gas there is hot.
    pub pace_sd: f64,
    /// Dispersion of the way from each channel to the end and back, s^{1/2}: see
    /// [`ClickOptions::dispersion`]. Empty for none.
    pub dispersion: Vec<f64>,
}

impl Reflection {
    /// Whether all but the lags, of which some may be endless, are finite.
    fn is_finite(&self) -> bool {
        [self.strength, self.smoothing, self.tolerance, self.pace_sd].into_iter().all(f64::is_finite)
            && !self.lags.iter().any(|lag| lag.is_nan())
    }
}

impl Default for ClickOptions {
    /// For a tube of 5 cm: 300 Hz to 4 kHz, an impulse that is over within 0.7 ms of its peak.
    fn default() -> Self {
        Self {
            band_hz: (300.0, 4000.0),
            mains_hz: 50.0,
            window: (0.8e-3, 0.8e-3),
            dispersion: Vec::new(),
            reflection: None,
            leaning: true,
        }
    }
}

impl ClickOptions {
    /// Refuses options with which no click of `trace` can be fitted.
    pub(super) fn check(&self, trace: &Trace<'_>) -> Result<(), Fault> {
        let positive = |v: f64| v.is_finite() && v > 0.0;
        let finite = |values: &[f64]| values.iter().all(|v| v.is_finite());
        let one_each = |values: &[f64]| values.is_empty() || values.len() == trace.channels.len();
        let (low, high) = self.band_hz;
        let reflection = self.reflection.as_ref();
        let what = if !positive(trace.rate_hz) {
            "the sampling rate is no number above zero"
        } else if !(low.is_finite() && low >= 0.0 && high.is_finite() && low < high) {
            "the band is not two frequencies, the lower one first"
        } else if low >= 0.5 * trace.rate_hz {
            "the band lies above half the sampling rate"
        } else if !positive(self.mains_hz) {
            "the frequency of the mains is no number above zero"
        } else if !(positive(self.window.0) && positive(self.window.1)) {
            "the window is not two times above zero, before and after the peak"
        } else if (self.window.0 + self.window.1) * trace.rate_hz > trace.len() as f64 {
            "the window is longer than the record"
        } else if !(one_each(&self.dispersion) && finite(&self.dispersion)) {
            "the dispersion is not one number for each channel"
        } else if reflection.is_some_and(|r| !(one_each(&r.lags) && one_each(&r.dispersion))) {
            "the lags or the dispersion of the reflection are not one for each channel"
        } else if reflection.is_some_and(|r| !(finite(&r.dispersion) && r.is_finite())) {
            "a number of the reflection is not finite"
        } else if reflection.is_some_and(|r| r.lags.iter().any(|lag| *lag <= 0.0)) {
            "a reflection comes no later than its impulse"
        } else {
            return Ok(());
        };
        Err(Fault::Options(what))
    }

    /// Multiplies the lags of the reflection by `pace`.
    pub(super) fn hasten(&mut self, pace: f64) {
        if let Some(reflection) = &mut self.reflection {
            reflection.lags.iter_mut().for_each(|lag| *lag *= pace);
        }
    }

    /// Whether the pace of the reflection is not known.
    pub(super) fn free(&self) -> bool {
        self.reflection.as_ref().is_some_and(|r| r.pace_sd > 0.0)
    }

    /// Whether the reflection at channel `m` overlaps the centre of the direct impulse, so that the window
    /// cannot end before it.
    pub(super) fn overlaps(&self, m: usize) -> bool {
        self.lag(m).is_some_and(|lag| lag - self.window.0 < 0.4 * self.window.1)
    }

    /// End of the window of channel `m` after the impulse's centre, s.
    pub(super) fn end(&self, m: usize) -> f64 {
        match self.lag(m) {
            Some(lag) if !self.overlaps(m) => self.window.1.min(lag - self.window.0),
            _ => self.window.1,
        }
    }

    /// Lag of the reflection at channel `m`.
    pub(super) fn lag(&self, m: usize) -> Option<f64> {
        self.reflection.as_ref().and_then(|r| r.lags.get(m).copied())
    }
}

/// One impulse, fitted. Times count from the end of the quiet part (the trigger) and contain channel delays
/// and an origin of the waveform that is arbitrary until a calibration fixes it: see
/// [`crate::ChannelDelays`].
#[derive(Clone, Debug)]
pub struct ClickFit {
    /// Arrival times, s; that of channel `pivot` is exact by definition, its error sits in the waveform.
    pub times: Vec<f64>,
    /// Gain of each channel relative to channel `pivot`; negative if inverted.
    pub gains: Vec<f64>,
    /// Covariance of `times`, s^2, relative to `pivot` (whose row is zero).
    pub covariance: Matrix,
    /// Covariance of `gains`, relative to `pivot` (whose row is zero).
    pub gain_covariance: Matrix,
    /// The strongest channel.
    pub pivot: usize,
    /// Angular frequencies of the waveform, rad/s.
    pub frequencies: Vec<f64>,
    /// Spectrum of the waveform at these, in the gain of the pivot channel and an arbitrary unit per
    /// frequency.
    pub waveform: Vec<C64>,
    /// Frequencies between which it was fitted, Hz.
    pub band_hz: (f64, f64),
    /// Taps of the reflection; empty if none was fitted.
    pub reflection: Vec<f64>,
    /// Error of the time (s) and relative error of the gain of each channel, if the far end is another one
    /// than the fit takes it for: a list for an end that is as much longer as a flange makes it, for one with
    /// a flange, and for one that takes 2 % of the amplitude. Where the reflection overlaps the impulse,
    /// times and gains lean on what is not known of the end. Empty where it overlaps nowhere, and where its
    /// lag is not known.
    pub leaning: Vec<Vec<[f64; 2]>>,
    /// Whether the reflection overlaps the impulse at each channel.
    pub overlapped: Vec<bool>,
    /// Root of (energy over noise energy) per channel: the amplitude that a matched filter sees.
    pub signal_to_noise: Vec<f64>,
    /// Sum of squared residuals over its number of degrees of freedom.
    pub chi_squared: f64,
    /// Energy of the residuals beyond that of the noise, over the energy of the impulse in all channels;
    /// below zero where the noise happens to be small, zero where it is not known.
    pub misfit: f64,
    /// Covariance of times, then of real and imaginary parts of the waveform.
    pub(crate) joint: Matrix,
}
