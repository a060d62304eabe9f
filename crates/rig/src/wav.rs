//! Multichannel WAV in and out.

use crate::arrays::{is_file_of_arrays, read_array_record};
use crate::blocks::is_text;
use crate::files::write_whole;
use crate::span::{ALL, gather};
use crate::{Arrays, Problem, Reading, Record, RigError};
use hound::{SampleFormat, WavSpec, WavWriter};
use std::io::Cursor;
use std::path::Path;

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

/// The integers of one record as a 24-bit acquisition system delivers them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Samples24 {
    /// Sampling rate, Hz.
    pub rate_hz: u32,
    /// Samples of all channels, interleaved, from -2^23 to 2^23 - 1.
    pub interleaved: Vec<i32>,
}

/// The largest magnitude of a 24-bit sample is 2^23.
const SCALE_24: f64 = 8_388_608.0;

impl Samples24 {
    /// The integer that stands for `fraction` of full scale: rounded, and limited at the ends of the range.
    #[must_use]
    pub fn quantise(fraction: f64) -> i32 {
        let steps = (fraction * SCALE_24).clamp(-SCALE_24, SCALE_24 - 1.0);
        (steps + 0.5_f64.copysign(steps)) as i32
    }

    /// Pressure of one step of the converter whose range ends at `full_scale`.
    #[must_use]
    pub fn unit(full_scale: f64) -> f64 {
        full_scale / SCALE_24
    }

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

    /// Writes a 24-bit WAV file in one step.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self, channels: u16, path: &Path) -> Result<(), RigError> {
        let failed = |error| RigError::Write { path: path.to_owned(), cause: std::io::Error::other(error) };
        let spec = WavSpec {
            channels,
            sample_rate: self.rate_hz,
            bits_per_sample: 24,
            sample_format: SampleFormat::Int,
        };
        let mut bytes = Cursor::new(Vec::with_capacity(3 * self.interleaved.len() + 100));
        let mut writer = WavWriter::new(&mut bytes, spec).map_err(failed)?;
        for &sample in &self.interleaved {
            writer.write_sample(sample).map_err(failed)?;
        }
        writer.finalize().map_err(failed)?;
        write_whole(path, bytes.get_ref())
    }
}

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

/// The first sample that is not a number, if any.
pub(crate) fn finite(record: &Record) -> Result<(), (String, Problem)> {
    for (m, channel) in record.channels.iter().enumerate() {
        if let Some((sample, &value)) = channel.iter().enumerate().find(|(_, p)| !p.is_finite()) {
            return Err((format!("microphone {m}"), Problem::NotFinite { sample, value }));
        }
    }
    Ok(())
}

/// From the bytes of one sample to its value.
pub(crate) type Decode = fn(&[u8]) -> f64;

/// What turns the little-endian bytes of one sample into its integer or floating value, and the steps of full
/// scale of an integer.
pub(crate) fn pcm(spec: WavSpec) -> Option<(Decode, Option<f64>)> {
    let steps = || Some(2.0_f64.powi(i32::from(spec.bits_per_sample) - 1));
    match (spec.sample_format, spec.bits_per_sample) {
        (SampleFormat::Int, 16) => Some((|b| f64::from(i16::from_le_bytes([b[0], b[1]])), steps())),
        (SampleFormat::Int, 24) => {
            Some((|b| f64::from(i32::from_le_bytes([0, b[0], b[1], b[2]]) >> 8), steps()))
        }
        (SampleFormat::Int, 32) => {
            Some((|b| f64::from(i32::from_le_bytes([b[0], b[1], b[2], b[3]])), steps()))
        }
        (SampleFormat::Float, 32) => {
            Some((|b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])), None))
        }
        _ => None,
    }
}
