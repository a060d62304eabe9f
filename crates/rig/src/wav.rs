//! Multichannel WAV in and out.

use crate::arrays::{is_file_of_arrays, read_array_record};
use crate::files::write_whole;
use crate::text_record::read_text_record;
use crate::{Arrays, Problem, Record, RigError};
use hound::{SampleFormat, WavReader, WavSpec, WavWriter};
use std::fs::File;
use std::io::{BufReader, Cursor, Read};
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

    /// The record that reading the file would give, bit for bit.
    #[must_use]
    pub fn record(&self, layout: Layout<'_>) -> Record {
        let count = layout.channels.len();
        let frames = self.interleaved.len() / count.max(1);
        let unit = Self::unit(layout.full_scale);
        spread(layout, frames, layout.full_scale, |k| f64::from(self.interleaved[k]) * unit)
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

/// Reads one record: text if the name ends in .csv, .tsv or .txt, else MATLAB, HDF5 or WAV.
///
/// # Errors
/// Those of [`read_wav`]; in text, a cell that is not a number; an array that is not in the file.
pub fn read_record(path: &Path, layout: Layout<'_>) -> Result<Record, RigError> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    match extension.as_str() {
        "csv" | "tsv" | "txt" => read_text_record(path, layout),
        _ if is_file_of_arrays(path)? => read_array_record(path, layout),
        _ => read_wav(path, layout),
    }
}

/// Reads one record from a WAV file.
///
/// # Errors
/// The file is absent, not a WAV file, truncated, sampled at another rate, lacks a channel, or holds NaN. A clipped
/// record is not an error: that is for signal processing to judge.
pub fn read_wav(path: &Path, layout: Layout<'_>) -> Result<Record, RigError> {
    let wrong = |place: &str, problem| RigError::invalid(path, place, problem);
    let (spec, reader) = header(path)?;
    let frames = reader.duration() as usize;
    let (have, need) = (usize::from(spec.channels), layout.channels.len());
    if have < need {
        return Err(wrong("header", Problem::MissingChannel { have, need }));
    }
    let (have_rate, need_rate) = (f64::from(spec.sample_rate), layout.rate_hz);
    if (have_rate - need_rate).abs() > 0.5 {
        return Err(wrong("header", Problem::WrongRate { have: have_rate, need: need_rate }));
    }
    if frames <= layout.quiet {
        return Err(wrong("samples", Problem::TooShort { have: frames, quiet: layout.quiet }));
    }
    let decode = decoder(spec).ok_or_else(|| {
        let reason = format!("{} bit {:?} samples", spec.bits_per_sample, spec.sample_format);
        wrong("header", Problem::BadWav { reason })
    })?;
    let width = usize::from(spec.bits_per_sample / 8);
    let needed = frames * have * width;
    let file = reader.into_inner();
    // A damaged header may announce gigabytes.
    let size = file.get_ref().metadata().map_err(RigError::read(path))?.len();
    let mut bytes = Vec::with_capacity(needed.min(usize::try_from(size).unwrap_or(needed)));
    file.take(needed as u64).read_to_end(&mut bytes).map_err(RigError::read(path))?;
    if bytes.len() < needed {
        let read = bytes.len() / (have * width);
        return Err(wrong("samples", Problem::Truncated { have: read, need: frames }));
    }
    let float = spec.sample_format == SampleFormat::Float;
    let (unit, full_scale) = match float {
        true => (1.0, f64::INFINITY),
        false => (layout.full_scale / f64::from(1_u32 << (spec.bits_per_sample - 1)), layout.full_scale),
    };
    let mut padded = layout.channels.to_vec();
    padded.resize(have, None);
    let wide = Layout { channels: &padded, ..layout };
    let record = spread(wide, frames, full_scale, |k| decode(&bytes[k * width..(k + 1) * width]) * unit);
    if float {
        finite(&record).map_err(|(place, problem)| wrong(&place, problem))?;
    }
    Ok(record)
}

/// The header of a WAV file, and the rest of it to read.
pub(crate) fn header(path: &Path) -> Result<(WavSpec, WavReader<BufReader<File>>), RigError> {
    let file = File::open(path).map_err(RigError::read(path))?;
    let reader = WavReader::new(BufReader::new(file)).map_err(|error| match error {
        hound::Error::IoError(cause) if cause.raw_os_error().is_some() => {
            RigError::Read { path: path.to_owned(), cause }
        }
        other => RigError::invalid(path, "header", Problem::BadWav { reason: other.to_string() }),
    })?;
    Ok((reader.spec(), reader))
}

/// De-interleaves: `sample(k)` is the k-th value of the file in Pa.
pub(crate) fn spread(
    layout: Layout<'_>,
    frames: usize,
    full_scale: f64,
    sample: impl Fn(usize) -> f64,
) -> Record {
    let stride = layout.channels.len();
    let microphones = layout.channels.iter().flatten().max().map_or(0, |m| m + 1);
    let mut channels = vec![Vec::new(); microphones];
    for (c, microphone) in layout.channels.iter().enumerate() {
        if let Some(m) = microphone {
            channels[*m] = (0..frames).map(|n| sample(n * stride + c)).collect();
        }
    }
    Record { rate_hz: layout.rate_hz, quiet: layout.quiet, full_scale, channels }
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

/// Turns the little-endian bytes of one sample into its integer or floating value.
fn decoder(spec: WavSpec) -> Option<fn(&[u8]) -> f64> {
    match (spec.sample_format, spec.bits_per_sample) {
        (SampleFormat::Int, 16) => Some(|b| f64::from(i16::from_le_bytes([b[0], b[1]]))),
        (SampleFormat::Int, 24) => Some(|b| f64::from(i32::from_le_bytes([0, b[0], b[1], b[2]]) >> 8)),
        (SampleFormat::Int, 32) => Some(|b| f64::from(i32::from_le_bytes([b[0], b[1], b[2], b[3]]))),
        (SampleFormat::Float, 32) => Some(|b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]))),
        _ => None,
    }
}
