//! A multichannel record as plain data, and what can be said against it before any fit.

use crate::Fault;

/// One multichannel record. Borrowed, so that any source of samples will do.
#[derive(Clone, Copy, Debug)]
pub struct Trace<'a> {
    /// Samples of each channel; all channels have the same length. Any unit.
    pub channels: &'a [Vec<f64>],
    /// Sampling rate, Hz.
    pub rate_hz: f64,
    /// The first `quiet` samples hold noise only.
    pub quiet: usize,
    /// Samples of this size or more are clipped; infinity if the limit is not known (flat tops are then looked for).
    pub full_scale: f64,
}

/// This many equal samples in a row are a dropout. Noise of less than one step of the converter could do the same,
/// but a record that coarse carries no usable ping either.
const DROPOUT: usize = 24;
/// A channel of steps of the converter, whose samples span less than this share of the median channel, is missing.
const SILENCE: f64 = 1e-3;
/// This many equal samples in a row at the extreme value of a channel are a flat top.
const FLAT_TOP: usize = 4;

impl Trace<'_> {
    /// Number of samples per channel.
    #[must_use]
    pub fn len(&self) -> usize {
        self.channels.first().map_or(0, Vec::len)
    }

    /// Whether there are no samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Refuses a record whose samples cannot be right: unequal lengths, numbers that are not finite, clipped,
    /// missing or interrupted channels. `need` is the shortest record that the caller can use.
    ///
    /// # Errors
    /// The first [`Fault`] found.
    pub fn screen(&self, need: usize) -> Result<(), Fault> {
        let have = self.len();
        if have < need.max(1) {
            return Err(Fault::TooShort { what: "record", have, need: need.max(1) });
        }
        let mut extremes = Vec::with_capacity(self.channels.len());
        for (channel, samples) in self.channels.iter().enumerate() {
            if samples.len() != have {
                return Err(Fault::UnequalChannels { channel, have: samples.len(), need: have });
            }
            if let Some(sample) = samples.iter().position(|y| !y.is_finite()) {
                return Err(Fault::NotFinite { channel, sample });
            }
            extremes.push(
                samples.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |e, &y| (y.min(e.0), y.max(e.1))),
            );
        }
        let mut spans: Vec<f64> = extremes.iter().map(|(low, high)| high - low).collect();
        spans.sort_by(f64::total_cmp);
        let median = spans[spans.len() / 2];
        for (channel, (samples, extremes)) in self.channels.iter().zip(extremes).enumerate() {
            self.screen_channel(channel, samples, extremes, median)?;
        }
        Ok(())
    }

    fn screen_channel(
        &self,
        channel: usize,
        samples: &[f64],
        (low, high): (f64, f64),
        median: f64,
    ) -> Result<(), Fault> {
        let span = high - low;
        if span == 0.0 {
            return Err(Fault::DeadChannel { channel, span, median });
        }
        let limit = self.full_scale * (1.0 - 1e-6);
        let (mut at_limit, mut at_extreme) = (0, [0, 0]);
        let (mut run, mut run_start) = (1, 0);
        for (n, &y) in samples.iter().enumerate() {
            at_limit += usize::from(y.abs() >= limit);
            if n > 0 && y == samples[n - 1] {
                run += 1;
            } else {
                (run, run_start) = (1, n);
            }
            if run == FLAT_TOP && (y == low || y == high) {
                at_extreme[usize::from(y == high)] += 1;
            }
            if run == DROPOUT && span < SILENCE * median {
                return Err(Fault::DeadChannel { channel, span, median });
            }
            if run == DROPOUT && y != low && y != high {
                let length = samples[run_start..].iter().take_while(|&&v| v == y).count();
                return Err(Fault::Dropout { channel, at: run_start as f64 / self.rate_hz, samples: length });
            }
        }
        if at_limit > 0 {
            return Err(Fault::Clipped { channel, samples: at_limit, level: self.full_scale });
        }
        for (tops, level) in at_extreme.into_iter().zip([low, high]) {
            if tops > 0 {
                let count = samples.iter().filter(|&&y| y == level).count();
                return Err(Fault::Clipped { channel, samples: count, level });
            }
        }
        Ok(())
    }
}
