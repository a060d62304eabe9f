//! Bad records: what goes wrong in a laboratory now and then.

use super::noise::Hum;
use rand::RngExt;
use rijke_numerics::Stream;

/// One way in which a record is bad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BadRecord {
    /// The gain was set too high: the record runs into the limits of the recorder.
    Clipped,
    /// This microphone was not connected.
    Dead(usize),
    /// The loudspeaker started again this long after it stopped, s.
    DoubleTrigger(f64),
    /// No samples arrived from the first moment for the second long, s after the end of forcing: zeros
    /// instead.
    Dropout(f64, f64),
    /// Mains hum a hundred times the usual, from the first moment for the second long, s.
    HumBurst(f64, f64),
    /// This microphone was connected the wrong way round.
    WrongPolarity(usize),
}

impl BadRecord {
    /// Whether this ping is bad, and how: with probability `fraction`, all kinds equally often.
    pub(crate) fn of_ping(fraction: f64, microphones: usize, stream: &mut Stream) -> Option<Self> {
        let bad = stream.random::<f64>() < fraction;
        let (kind, microphone) = (stream.random_range(0..6), stream.random_range(0..microphones));
        let at = stream.random_range(0.02..0.15);
        let fault = match kind {
            0 => Self::Clipped,
            1 => Self::Dead(microphone),
            2 => Self::DoubleTrigger(at),
            3 => Self::Dropout(at, 0.04),
            4 => Self::HumBurst(at, 0.3),
            _ => Self::WrongPolarity(microphone),
        };
        bad.then_some(fault)
    }

    /// Whether this click is bad, and how.
    pub(crate) fn of_click(fraction: f64, microphones: usize, stream: &mut Stream) -> Option<Self> {
        let bad = stream.random::<f64>() < fraction;
        let (kind, microphone) = (stream.random_range(0..4), stream.random_range(0..microphones));
        let fault = match kind {
            0 => Self::Clipped,
            1 => Self::Dead(microphone),
            2 => Self::HumBurst(0.0, 0.08),
            _ => Self::WrongPolarity(microphone),
        };
        bad.then_some(fault)
    }

    /// Does to finished channels (Pa, every `dt` s, event at `event` s, limit `full_scale` Pa) what the fault
    /// does. A second trigger is made with the ping itself and changes nothing here.
    pub(crate) fn apply(self, channels: &mut [Vec<f64>], dt: f64, event: f64, full_scale: f64, hum: &Hum) {
        let span = |from: f64, long: f64, length: usize| {
            let first = (((event + from) / dt) as usize).min(length);
            first..(first + (long / dt) as usize).min(length)
        };
        match self {
            Self::Clipped => {
                let loudest = channels.iter().flatten().fold(0.0_f64, |a, p| a.max(p.abs()));
                let gain = 1.5 * full_scale / loudest.max(f64::MIN_POSITIVE);
                channels.iter_mut().flatten().for_each(|p| *p *= gain);
            }
            Self::Dead(m) => channels[m].iter_mut().for_each(|p| *p *= 1e-5),
            Self::WrongPolarity(m) => channels[m].iter_mut().for_each(|p| *p = -*p),
            Self::Dropout(from, long) => {
                for channel in channels {
                    let span = span(from, long, channel.len());
                    channel[span].fill(0.0);
                }
            }
            Self::HumBurst(from, long) => {
                for channel in channels {
                    let span = span(from, long, channel.len());
                    let first = span.start;
                    hum.add(&mut channel[span], first, 100.0);
                }
            }
            Self::DoubleTrigger(_) => {}
        }
    }
}
