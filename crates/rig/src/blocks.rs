//! WAV and text a block of frames at a time, so that a file may be larger than memory.

use crate::riff::{WavHeader, header};
use crate::wav::{Decode, Layout, pcm};
use crate::{Problem, RigError};
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

/// Frames that a block holds at most.
pub(crate) const BLOCK: usize = 4096;

/// Bytes of a file that a block holds at most.
const BYTES: usize = 1 << 23;

/// The frames of a file, one after another: all that is held is one block.
pub(crate) struct Blocks<'a> {
    path: &'a Path,
    /// Values of a frame: one for each channel of the layout.
    pub(crate) width: usize,
    /// Largest pressure that the file can hold, Pa; infinite for floats and text.
    pub(crate) full_scale: f64,
    source: Source,
}

enum Source {
    Wav {
        file: BufReader<File>,
        decode: Decode,
        unit: f64,
        sample: usize,
        stride: usize,
        frames: usize,
        read: usize,
    },
    Text {
        file: BufReader<File>,
        separator: Option<char>,
        line: usize,
    },
}

/// Whether the name is that of a text file.
pub(crate) fn is_text(path: &Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    matches!(extension.as_str(), "csv" | "tsv" | "txt")
}

impl<'a> Blocks<'a> {
    /// Opens a file and checks it against what the manifest says.
    ///
    /// # Errors
    /// The file is absent, not of its format, sampled at another rate, or lacks a channel.
    pub(crate) fn open(path: &'a Path, layout: Layout<'_>) -> Result<Self, RigError> {
        let width = layout.channels.len();
        if width == 0 {
            return Err(RigError::invalid(path, "header", Problem::Empty { need: "one channel" }));
        }
        if is_text(path) {
            let file = BufReader::new(File::open(path).map_err(RigError::read(path))?);
            let source = Source::Text { file, separator: None, line: 0 };
            return Ok(Self { path, width, full_scale: f64::INFINITY, source });
        }
        let wrong = |problem| RigError::invalid(path, "header", problem);
        let WavHeader { spec, frames, samples: file } = header(path)?;
        let have = usize::from(spec.channels);
        if have < width {
            return Err(wrong(Problem::MissingChannel { have, need: width }));
        }
        let (have_rate, need_rate) = (f64::from(spec.sample_rate), layout.rate_hz);
        if (have_rate - need_rate).abs() > 0.5 {
            return Err(wrong(Problem::WrongRate { have: have_rate, need: need_rate }));
        }
        let (decode, steps) = pcm(spec).ok_or_else(|| {
            let reason = format!("{} bit {:?} samples", spec.bits_per_sample, spec.sample_format);
            wrong(Problem::BadWav { reason })
        })?;
        let (unit, full_scale) = match steps {
            Some(steps) => (layout.full_scale / steps, layout.full_scale),
            None => (1.0, f64::INFINITY),
        };
        let sample = usize::from(spec.bits_per_sample / 8);
        let stride = have * sample;
        let source = Source::Wav { file, decode, unit, sample, stride, frames, read: 0 };
        Ok(Self { path, width, full_scale, source })
    }

    /// A number of frames that the file does not exceed, from its header or its size.
    ///
    /// # Errors
    /// The size cannot be read.
    pub(crate) fn most_frames(&self) -> Result<usize, RigError> {
        match &self.source {
            Source::Wav { frames, .. } => Ok(*frames),
            Source::Text { file, .. } => {
                let size = file.get_ref().metadata().map_err(RigError::read(self.path))?.len();
                // A cell takes two bytes, its separator included.
                Ok(size as usize / (2 * self.width))
            }
        }
    }

    /// The next frames, interleaved, in place of what `block` holds; their number, 0 at the end.
    ///
    /// # Errors
    /// The file ends before its header says, a row lacks a channel, or a cell is no number.
    pub(crate) fn next(&mut self, block: &mut Vec<f64>) -> Result<usize, RigError> {
        block.clear();
        match &mut self.source {
            Source::Wav { file, decode, unit, sample, stride, frames, read } => {
                // A damaged header may announce thousands of channels.
                let wanted = BLOCK.min(*frames - *read).min((BYTES / *stride).max(1));
                let mut bytes = Vec::with_capacity(wanted * *stride);
                let limit = (wanted * *stride) as u64;
                file.take(limit).read_to_end(&mut bytes).map_err(RigError::read(self.path))?;
                let have = *read + bytes.len() / *stride;
                if bytes.len() < wanted * *stride {
                    let problem = Problem::Truncated { have, need: *frames };
                    return Err(RigError::invalid(self.path, "samples", problem));
                }
                for frame in bytes.chunks_exact(*stride) {
                    let samples = frame.chunks_exact(*sample).take(self.width);
                    block.extend(samples.map(|bytes| decode(bytes) * *unit));
                }
                *read = have;
                Ok(wanted)
            }
            Source::Text { file, separator, line } => {
                let mut bytes = Vec::new();
                while block.len() < BLOCK * self.width {
                    bytes.clear();
                    if file.read_until(b'\n', &mut bytes).map_err(RigError::read(self.path))? == 0 {
                        break;
                    }
                    *line += 1;
                    let text = String::from_utf8_lossy(&bytes);
                    let mut row = text.trim_end_matches(['\n', '\r']);
                    let separator = *separator.get_or_insert_with(|| {
                        row = row.strip_prefix('\u{feff}').unwrap_or(row);
                        shape(row).0
                    });
                    let names = *line == 1 && shape(row).1;
                    if !names && !row.trim().is_empty() {
                        cells(row, separator, self.width, block).map_err(|(column, problem)| {
                            let place = match column {
                                Some(column) => format!("line {line}, column {column}"),
                                None => format!("line {line}"),
                            };
                            RigError::invalid(self.path, place, problem)
                        })?;
                    }
                }
                Ok(block.len() / self.width.max(1))
            }
        }
    }
}

/// Appends the first `width` cells of a row; or the column, from 1, and what is wrong.
fn cells(
    row: &str,
    separator: char,
    width: usize,
    out: &mut Vec<f64>,
) -> Result<(), (Option<usize>, Problem)> {
    let have = row.split(separator).count();
    if have < width {
        return Err((None, Problem::MissingChannel { have, need: width }));
    }
    for (column, cell) in row.split(separator).take(width).enumerate() {
        let value = cell.trim().parse::<f64>().map_err(|_| {
            let (text, expected) = (cell.trim().to_owned(), "a number with a decimal point");
            (Some(column + 1), Problem::BadCell { text, expected })
        })?;
        out.push(value);
    }
    Ok(())
}

/// The character between columns, and whether the row holds names: a row of names has no number in it; one with some
/// numbers is data, and its bad cells are reported.
fn shape(row: &str) -> (char, bool) {
    let separator = [';', '\t', ','].into_iter().find(|c| row.contains(*c)).unwrap_or(',');
    (separator, row.split(separator).all(|cell| cell.trim().parse::<f64>().is_err()))
}

/// The columns of a text record, with their names if it has any.
pub(crate) fn columns(path: &Path) -> Result<Vec<Option<String>>, RigError> {
    let mut bytes = Vec::new();
    let mut file = BufReader::new(File::open(path).map_err(RigError::read(path))?);
    file.read_until(b'\n', &mut bytes).map_err(RigError::read(path))?;
    let text = String::from_utf8_lossy(&bytes);
    let row = text.trim_end_matches(['\n', '\r']);
    let row = row.strip_prefix('\u{feff}').unwrap_or(row);
    let (separator, named) = shape(row);
    Ok(row.split(separator).map(|cell| named.then(|| cell.trim().to_owned())).collect())
}
