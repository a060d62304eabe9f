//! Why a calibration cannot be used.

use crate::{Channel, ChannelExchange, Fault};

/// Why a calibration cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CalibrationError {
    /// Too few clicks.
    #[error("a calibration needs at least 2 usable clicks, there are {have}")]
    TooFew {
        /// Usable clicks.
        have: usize,
    },
    /// The clicks and the expected arrivals do not fit together.
    #[error("the clicks have {channels} channels and {frequencies} frequencies, {expected} were expected")]
    Mismatch {
        /// Channels of the offending click.
        channels: usize,
        /// Frequencies of its waveform.
        frequencies: usize,
        /// Channels expected.
        expected: usize,
    },
    /// The channels do not show the same impulse.
    #[error(
        "the channels do not show one impulse: the residual of one common impulse has {:.2} % of its energy, and {:.2} % are allowed: make a shorter, \
         cleaner click",
        100.0 * share, 100.0 * limit
    )]
    Misfit {
        /// Energy left over, relative to that of the impulse.
        share: f64,
        /// What is allowed.
        limit: f64,
    },
    /// A gain that no calibration explains.
    #[error(
        "{channel} has a gain of {gain:.3} where the median of the channels has {median:.3}, and gains may differ by {:.0} %: {}",
        100.0 * spread, gain_remedy(*gain / *median, *overlapped)
    )]
    ImplausibleGain {
        /// The channel.
        channel: Channel,
        /// Its gain.
        gain: f64,
        /// The median.
        median: f64,
        /// Difference from the median that is allowed, relative to it.
        spread: f64,
        /// Whether the reflection of the end overlaps the impulse at this channel.
        overlapped: bool,
    },
    /// Channels that hold the records of each other.
    #[error(
        "{exchange} in {clicks} of {of} calibration clicks{}. Their delays differ by {:.0} us, and by {:.0} us if they are exchanged back; sound \
         takes {:.0} us from the one to the other. Check the wiring, and give the right `channels` in the manifest, of single files in an [[exception]]",
        first.as_ref().map_or(String::new(), |record| format!(", the first of them {record}")),
        1e6 * delays[0], 1e6 * delays[1], 1e6 * travel
    )]
    Exchanged {
        /// Which.
        exchange: ChannelExchange,
        /// How many clicks say so, and of how many.
        clicks: usize,
        /// All clicks.
        of: usize,
        /// The number of the first of them among all clicks.
        click: usize,
        /// Its name, where it is known and others do not say so.
        first: Option<String>,
        /// How far the delays of two channels are apart as they are, and exchanged back, s.
        delays: [f64; 2],
        /// Travel time between the two, s.
        travel: f64,
    },
    /// Sound runs the other way.
    #[error(
        "sound comes to {} first and to {} last in {clicks} of {of} calibration clicks, as from a click at the end that should reflect it: make the click \
         at the end from which `positions` in the rig are counted, or count the positions from the other end",
        ends[0], ends[1]
    )]
    OtherEnd {
        /// The channels that hear it first and last.
        ends: [Channel; 2],
        /// How many clicks say so.
        clicks: usize,
        /// All clicks.
        of: usize,
    },
    /// Two delays that differ by more than those of channels do.
    #[error(
        "the clicks arrive {:.0} us later at {}, relative to {}, than its place predicts, and sound takes {:.0} us from the one to the other: channels \
         of one converter differ by less. Check that the microphones are at the `positions` of the rig, and the channels in the order of the manifest",
        1e6 * difference, channels[1], channels[0], 1e6 * travel
    )]
    UnequalDelays {
        /// The two; the second has the larger delay.
        channels: [Channel; 2],
        /// Difference of their delays, s.
        difference: f64,
        /// Travel time between them, s.
        travel: f64,
    },
    /// A delay that belongs to another place.
    #[error(
        "the clicks arrive {:.0} us later at {channel}, relative to the median of the channels, than its place predicts; sound takes {:.0} us from one \
         microphone to the next: check that the channels are in the order of the manifest",
        1e6 * delay, 1e6 * limit
    )]
    ImplausibleDelay {
        /// The channel.
        channel: Channel,
        /// Its delay less the median of all, s.
        delay: f64,
        /// Travel time between neighbouring microphones, s.
        limit: f64,
    },
    /// The waveforms of the clicks cannot be brought in phase.
    #[error("the waveforms of the clicks cannot be compared: {0}")]
    Waveform(#[from] Fault),
}

/// What to do about a gain that lies by this factor from the median.
fn gain_remedy(ratio: f64, overlapped: bool) -> String {
    let cause = if (ratio + 1.0).abs() < 0.3 {
        "look whether its wires are swapped"
    } else {
        "look after the sensitivity that is stated for it"
    };
    let overlap = "; the reflection of the end overlaps the click there, and the two may have been mistaken for one another: a \
                   click of another length will tell";
    format!("{cause}{}", if overlapped { overlap } else { "" })
}

impl CalibrationError {
    /// The same with the channel as the microphone that it is.
    pub(crate) fn called(mut self, microphones: &[Channel]) -> Self {
        if let Self::ImplausibleGain { channel, .. } | Self::ImplausibleDelay { channel, .. } = &mut self {
            channel.call(microphones);
        }
        if let Self::UnequalDelays { channels, .. } | Self::OtherEnd { ends: channels, .. } = &mut self {
            channels.iter_mut().for_each(|channel| channel.call(microphones));
        }
        if let Self::Exchanged { exchange, .. } = &mut self {
            exchange.call(microphones);
        }
        self
    }

    /// The same with the name of the first click that is exchanged, if `names` (of all clicks) has it and not
    /// all clicks are.
    pub(crate) fn with_names(mut self, names: &[&str]) -> Self {
        if let Self::Exchanged { clicks, of, click, first, .. } = &mut self
            && clicks < of
        {
            *first = names.get(*click).map(|name| (*name).to_owned());
        }
        self
    }
}

/// Refuses delays and gains that are none of channels; `overlapped` says of each whether the reflection of
/// the end overlaps its impulse.
pub(super) fn plausible(
    delays: &[f64],
    gains: &[f64],
    expected: &[f64],
    spread: f64,
    overlapped: &[bool],
) -> Result<(), CalibrationError> {
    let median = median_of(gains);
    let unlike = |gain: &f64| gain / median <= 0.0 || (gain / median - 1.0).abs() > spread;
    if let Some(channel) = gains.iter().position(unlike) {
        let overlapped = overlapped.get(channel).copied().unwrap_or(false);
        return Err(CalibrationError::ImplausibleGain {
            channel: channel.into(),
            gain: gains[channel],
            median,
            spread,
            overlapped,
        });
    }
    let mut sorted = expected.to_vec();
    sorted.sort_by(f64::total_cmp);
    let apart: Vec<f64> = sorted.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > 0.0).collect();
    let (middle, limit) =
        (median_of(delays), if apart.is_empty() { f64::INFINITY } else { median_of(&apart) });
    match delays.iter().position(|d| (d - middle).abs() > limit) {
        Some(channel) => Err(CalibrationError::ImplausibleDelay {
            channel: channel.into(),
            delay: delays[channel] - middle,
            limit,
        }),
        None => Ok(()),
    }
}

pub(super) fn median_of(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
}
