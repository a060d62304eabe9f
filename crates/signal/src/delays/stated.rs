//! Channels whose gains and delays are stated, not calibrated.

/// What is known of channels without a calibration: gains of 1, delays of 0, and how well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelPriors {
    /// Relative standard deviation of each gain.
    pub gain_sd: f64,
    /// Standard deviation of each delay, s.
    pub delay_sd: f64,
}
