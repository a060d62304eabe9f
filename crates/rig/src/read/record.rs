//! One record from one file of any format.

use super::array_record::read_array_record;
use super::blocks::is_text;
use super::gather::{ALL, gather};
use super::layout::Layout;
use crate::error::RigError;
use crate::formats::arrays::is_file_of_arrays;
use crate::formats::wav::Samples24;
use crate::records::record::Record;
use std::path::Path;

/// Reads one record: text if the name ends in .csv, .tsv, .txt, .dat or .asc, else MATLAB, HDF5 or WAV. Text:
/// comma, semicolon, tab or blanks between columns, lines before the numbers, names with units, a decimal
/// point or comma; its sampling rate is the manifest's, with which a column of time is compared. A dead
/// microphone has no samples.
///
/// # Errors
/// The file is absent, not of its format, truncated, sampled at another rate, lacks a channel or an array,
/// has one that is not listed, or holds NaN; in text, a cell is not a number; in WAV, a chunk is longer than
/// the file, or the recorder did not finish it. A clipped record is not an error: that is for signal
/// processing to judge.
pub fn read_record(path: &Path, layout: Layout<'_>) -> Result<Record, RigError> {
    if !is_text(path) && is_file_of_arrays(path)? {
        return read_array_record(path, layout);
    }
    gather(path, layout, &ALL, layout.quiet)
}

impl Samples24 {
    /// The record that reading the file would give, bit for bit, where `layout` has channels by their place
    /// and pressures.
    #[must_use]
    pub fn record(&self, layout: Layout<'_>) -> Record {
        let (stride, unit) = (layout.channels.len().max(1), Self::unit(layout.full_scale));
        let mut channels = vec![Vec::new(); layout.microphones()];
        for (c, microphone) in layout.channels.iter().enumerate() {
            if let Some(m) = microphone {
                let column = self.interleaved.chunks_exact(stride).map(|frame| f64::from(frame[c]) * unit);
                channels[*m] = column.collect();
            }
        }
        Record { rate_hz: layout.rate_hz, quiet: layout.quiet, full_scale: layout.full_scale, channels }
    }
}
