//! How a campaign is processed, and what processing gives.

use crate::click::ClickOptions;
use crate::delays::{CalibrationError, ChannelDelays, ChannelPriors};
use crate::ping::PingOptions;
use crate::repeats::Repeats;
use rijke_rig::{Observations, Rejection, RigError};

/// How a campaign is processed. Microphone positions, reference, gas and geometry come from the rig of the
/// record set.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProcessOptions {
    /// Fit of the pings; the reference microphone is replaced by the rig's.
    pub ping: PingOptions,
    /// Fit of the clicks; dispersion and reflection are replaced by the rig's, window and band by those that
    /// the calibration clicks need, if these do not hold them.
    pub click: ClickOptions,
    /// What is known of the channels at the pings' sampling rate without calibration clicks at that rate:
    /// used if there are none.
    pub stated: Option<ChannelPriors>,
    /// How far the gains of the channels may lie from their median, relative to it; none for 30 %.
    pub gain_spread: Option<f64>,
}

/// What processing made of a record set.
#[derive(Clone, Debug)]
pub struct Processed {
    /// What was measured, for inference.
    pub observations: Observations,
    /// Delays and gains at the pings' sampling rate; none if the set holds no ping.
    pub ping_delays: Option<ChannelDelays>,
    /// The same at the clicks' sampling rate.
    pub click_delays: Option<ChannelDelays>,
    /// How the pings were fitted: the options with the reference microphone and the decay times of the rig.
    pub ping: PingOptions,
    /// How the clicks were fitted: the options with the window and the band of the calibration clicks.
    pub click: ClickOptions,
    /// What a reader of the observations must know, in sentences: what was left out or assumed, and why.
    pub notes: Vec<String>,
    /// Scatter and drift of each operating point's pings and clicks, before correction.
    pub scatter: Vec<PointScatter>,
    /// Records in which something was put right, and what: a channel of opposite polarity.
    pub corrections: Vec<Rejection>,
    /// Number of records read, calibration included.
    pub records: usize,
}

/// How the repeats of one operating point agree.
#[derive(Clone, Debug)]
pub struct PointScatter {
    /// Of growth rate, frequency and relative pressures.
    pub ping: Option<Repeats>,
    /// Of the arrival times.
    pub click: Option<Repeats>,
}

/// Why a record set cannot be processed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ProcessError {
    /// A record cannot be read.
    #[error(transparent)]
    Record(#[from] RigError),
    /// The calibration clicks cannot be used.
    #[error("calibration at {rate_hz} Hz ({records}): {cause}{}", first_rejection.as_deref().map(|r| format!("; first rejected record: {r}")).unwrap_or_default())]
    Calibration {
        /// The sampling rate, Hz.
        rate_hz: f64,
        /// Its files: the first, and how many more.
        records: String,
        /// The reason.
        cause: Box<CalibrationError>,
        /// Why the first of the rejected records was rejected.
        first_rejection: Option<String>,
    },
    /// Every record was rejected.
    #[error("all {count} records were rejected; the first, {record}: {reason}")]
    NothingUsable {
        /// Number of records.
        count: usize,
        /// The first of them.
        record: String,
        /// Why it was rejected.
        reason: String,
    },
}
