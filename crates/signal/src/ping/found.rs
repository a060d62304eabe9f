//! What the fit of a ping has found.

use super::chirp::Drift;
use super::excess::Excesses;
use rijke_numerics::C64;
use rijke_rig::Ping;

/// One ring-down, fitted.
#[derive(Clone, Debug)]
pub struct PingFit {
    /// The measurement. Channel delays and gains are those of the record: see
    /// [`crate::ChannelDelays::correct`].
    pub ping: Ping,
    /// All modes fitted, the one of interest first, 1/s. The others are what is needed to leave noise alone:
    /// noise of a single channel feigns one in a third of all fits, of eight channels in hardly any.
    pub modes: Vec<C64>,
    /// First guess of the mode of interest, by ESPRIT; for comparison only.
    pub subspace_guess: C64,
    /// Complex amplitude of the mode of interest in each channel at `start`, units of the record.
    pub amplitudes: Vec<C64>,
    /// Every tone fitted, the mains after the modes: growth rate and frequency, 1/s, and amplitude in each
    /// channel at the start of the window, units of the record.
    pub tones: Vec<(C64, Vec<C64>)>,
    /// First and last time used, s from the first sample of the record.
    pub window: (f64, f64),
    /// How much of the decay was left out before the window because another mode sounds there, too near to be
    /// fitted with this one, s. Zero where none was.
    pub skipped_s: f64,
    /// Amplitude over noise in each channel; noise as the sd of white noise of equal density near the mode.
    pub signal_to_noise: Vec<f64>,
    /// Harmonics of the mains that were fitted, and their fundamental, Hz.
    pub mains: (Vec<u32>, f64),
    /// Variance of the residuals over that of the quiet part: 1 if the model holds.
    pub residual_variance: f64,
    /// Residuals, white and of unit variance if the model holds, row by row: the first thousand or so. Copies
    /// of a record have the same.
    pub noise: Vec<f32>,
    /// How the frequency of the mode drifts during the decay. If that is significant, `ping` and `modes` hold
    /// the frequency at the end of the forcing, with the error that the drift leaves; otherwise the frequency
    /// is that of about one decay time later.
    pub drift: Drift,
    /// How the damping depends on the amplitude. If that is significant, `ping` and `modes` hold the growth
    /// rate at small amplitude, with the error that the excess leaves.
    pub excess: Excesses,
}

impl PingFit {
    /// The ping with the frequency at the end of the forcing and the growth rate at small amplitude, and with
    /// the errors that any drift and any excess leave, found or not: those below what one record shows move
    /// frequency and growth rate by several of the errors that they would have without.
    #[must_use]
    pub fn at_the_end_of_forcing(&self) -> Ping {
        let mut ping = self.ping.clone();
        if !self.drift.is_significant() && self.drift.sd.is_finite() {
            self.drift.remove(&mut ping);
        }
        if !self.excess.is_significant() && self.excess.is_known() {
            self.excess.remove(&mut ping);
        }
        ping
    }
}
