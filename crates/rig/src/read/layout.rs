//! What the manifest says of a file that is to be read.

use crate::records::reading::{Arrays, Reading};

/// How to read a file: what the manifest says about it.
#[derive(Clone, Copy, Debug)]
pub struct Layout<'a> {
    /// For every channel of the file, the microphone it records.
    pub channels: &'a [Option<usize>],
    /// Pressure of the largest integer, Pa.
    pub full_scale: f64,
    /// Sampling rate, Hz.
    pub rate_hz: f64,
    /// Samples before the loudspeaker acts.
    pub quiet: usize,
    /// Which arrays hold the record, in a file that has named arrays.
    pub arrays: &'a Arrays,
    /// All else that the manifest says of the file.
    pub reading: &'a Reading,
}

impl Layout<'_> {
    /// Number of microphones that a record has a channel for.
    pub(crate) fn microphones(&self) -> usize {
        let listed = self.channels.iter().chain(self.reading.names.values()).flatten();
        listed.chain(&self.reading.dead).max().map_or(0, |m| m + 1)
    }
}
