//! What the fit of a ping may assume.

use crate::{Fault, Trace};

/// What the fit may assume.
#[derive(Clone, Debug, PartialEq)]
pub struct PingOptions {
    /// Channel to which the amplitudes are relative.
    pub reference: usize,
    /// Where the mode of interest lies, Hz: the strongest tone in this range is taken.
    pub band_hz: (f64, f64),
    /// Highest frequency at which neighbouring modes are looked for, Hz.
    pub highest_hz: f64,
    /// Nominal frequency of the mains, Hz; its harmonics are fitted if they stand out of the quiet part.
    pub mains_hz: f64,
    /// Decay times after its start that the fit uses: beyond 7 lies 0.03 % of the information on the growth
    /// rate.
    pub decay_times: f64,
    /// Whether a channel may lie at a node of the mode. If not, a channel without signal rejects the record.
    pub silent_channels: bool,
}

impl PingOptions {
    /// Refuses what no fit can be made with.
    pub(super) fn check(&self, trace: &Trace<'_>) -> Result<(), Fault> {
        let positive = |v: f64| v.is_finite() && v > 0.0;
        let (low, high) = self.band_hz;
        let what = if self.reference >= trace.channels.len() {
            "the reference is no channel of the record"
        } else if !positive(trace.rate_hz) {
            "the sampling rate is no number above zero"
        } else if !(positive(low) && high.is_finite() && low < high) {
            "the band is not two frequencies above zero, the lower one first"
        } else if low >= 0.5 * trace.rate_hz {
            "the band lies above half the sampling rate"
        } else if !(self.highest_hz.is_finite() && self.highest_hz > low) {
            "the highest frequency lies below the band"
        } else if !(positive(self.mains_hz) && positive(self.decay_times)) {
            "the frequency of the mains or the number of decay times is no number above zero"
        } else {
            return Ok(());
        };
        Err(Fault::Options(what))
    }
}

impl Default for PingOptions {
    /// For the fundamental of a metre of tube: 80 to 300 Hz, neighbours up to 1.3 kHz, 50 Hz mains, seven
    /// decay times: 61 dB.
    fn default() -> Self {
        Self {
            reference: 0,
            band_hz: (80.0, 300.0),
            highest_hz: 1300.0,
            mains_hz: 50.0,
            decay_times: 7.0,
            silent_channels: false,
        }
    }
}
