//! WAV: how the bytes of a sample become a number, and files of 24 bits as an acquisition system writes them.

use crate::error::RigError;
use crate::files::write_whole;
use hound::{SampleFormat, WavSpec, WavWriter};
use std::io::Cursor;
use std::path::Path;

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
