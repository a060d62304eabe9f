//! WAV and text a block of frames at a time, so that a file may be larger than memory.

use super::layout::Layout;
use super::plan::{Numbers, Plan};
use crate::error::RigError;
use crate::formats::riff::{WavHeader, header};
use crate::formats::text::{Form, HEAD, TextForm, next_line, refused};
use crate::formats::wav::{Decode, pcm};
use crate::problem::Problem;
use rijke_numerics::open_file;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

/// Frames that a block holds at most.
pub(crate) const BLOCK: usize = 4096;

/// Bytes of a file that a block holds at most.
const BYTES: usize = 1 << 23;

/// The frames of a file, one after another: all that is held is one block.
pub(crate) struct Blocks<'a> {
    path: &'a Path,
    /// Values of a frame: one for each column of the file. Those that the plan does not want are not read.
    pub(crate) width: usize,
    /// Which columns are taken, and what they are.
    pub(crate) plan: Plan,
    wanted: Vec<bool>,
    /// Largest pressure that the file can hold, Pa; infinite for floats and text.
    pub(crate) full_scale: f64,
    source: Source,
}

enum Source {
    Wav { file: BufReader<File>, decode: Decode, sample: usize, stride: usize, frames: usize, read: usize },
    Text { file: BufReader<File>, form: Form, line: usize },
}

/// Whether the name is that of a text file.
pub(crate) fn is_text(path: &Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    matches!(extension.as_str(), "csv" | "tsv" | "txt" | "dat" | "asc" | "lvm")
}

impl<'a> Blocks<'a> {
    /// Opens a file and checks it against what the manifest says.
    ///
    /// # Errors
    /// The file is absent, not of its format, sampled at another rate, or its columns are not those listed.
    pub(crate) fn open(path: &'a Path, layout: Layout<'_>) -> Result<Self, RigError> {
        if layout.channels.is_empty() && layout.reading.names.is_empty() {
            return Err(RigError::invalid(path, "header", Problem::Empty { need: "one channel" }));
        }
        let wrong = |(place, problem): (String, Problem)| RigError::invalid(path, place, problem);
        if is_text(path) {
            let (source, form) = text(path, &layout.reading.text)?;
            let width = form.width;
            // An empty file has no columns that could be wrong; it is found too short.
            let plan = if width == 0 {
                Plan::default()
            } else {
                Plan::of(layout, &form.headings, width, |_| Numbers::AsWritten).map_err(wrong)?
            };
            return Ok(Self::over(path, width, plan, f64::INFINITY, source));
        }
        let (source, largest, width, rate_hz) = wav(path)?;
        if layout.full_scale.is_infinite() && largest.is_some() {
            return Err(wrong(("header".into(), Problem::NoFullScale)));
        }
        let plan =
            Plan::of(layout, &[], width, |_| Numbers::of(largest, layout.full_scale)).map_err(wrong)?;
        let (have, need) = (rate_hz, layout.rate_hz);
        if (have - need).abs() > 0.5 {
            return Err(wrong(("header".into(), Problem::WrongRate { have, need })));
        }
        let full_scale = plan.full_scale();
        Ok(Self::over(path, width, plan, full_scale, source))
    }

    fn over(path: &'a Path, width: usize, plan: Plan, full_scale: f64, source: Source) -> Self {
        Self { path, width, wanted: plan.wanted(width), plan, full_scale, source }
    }

    /// Opens a file of which nothing is known: all columns, integers as fractions of full scale. Its names,
    /// or nothing.
    ///
    /// # Errors
    /// The file is absent or not of its format.
    pub(crate) fn raw(path: &'a Path) -> Result<(Self, Vec<String>), RigError> {
        if is_text(path) {
            let (source, form) = text(path, &TextForm::default())?;
            let plan = Plan::whole(form.width, 1.0);
            return Ok((Self::over(path, form.width, plan, f64::INFINITY, source), form.headings));
        }
        let (source, largest, width, _) = wav(path)?;
        let plan = Plan::whole(width, largest.map_or(1.0, |steps| 1.0 / steps));
        let full_scale = largest.map_or(f64::INFINITY, |_| 1.0);
        Ok((Self::over(path, width, plan, full_scale, source), Vec::new()))
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
                Ok(size as usize / (2 * self.width.max(1)))
            }
        }
    }

    /// The next frames, interleaved, in place of what `block` holds; their number, 0 at the end. Numbers are
    /// as the file has them: the plan's scale makes them Pa.
    ///
    /// # Errors
    /// The file ends before its header says, a row has another width, or a cell is no number.
    pub(crate) fn next(&mut self, block: &mut Vec<f64>) -> Result<usize, RigError> {
        block.clear();
        match &mut self.source {
            Source::Wav { file, decode, sample, stride, frames, read } => {
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
                block.extend(bytes.chunks_exact(*sample).map(*decode));
                *read = have;
                Ok(wanted)
            }
            Source::Text { file, form, line } => {
                let width = self.width;
                let most = BLOCK.min(BYTES / (8 * width.max(1))).max(1);
                while block.len() < most * width {
                    let Some(row) = next_line(file, self.path, *line + 1)? else { break };
                    *line += 1;
                    if *line <= form.before || Form::is_passed_over(&row) {
                        continue;
                    }
                    let start = block.len();
                    block.resize(start + width, 0.0);
                    form.row(
                        &row,
                        |column| self.wanted[column],
                        |column, value| block[start + column] = value,
                    )
                    .map_err(|(column, problem)| refused(self.path)((*line, column, problem)))?;
                }
                Ok(block.len() / width.max(1))
            }
        }
    }
}

/// A text file at its beginning, and how it is written.
fn text(path: &Path, declared: &TextForm) -> Result<(Source, Form), RigError> {
    let open = || open_file(path).map(BufReader::new).map_err(RigError::read(path));
    let form = Form::find(&head(&mut open()?, path, declared)?, declared).map_err(refused(path))?;
    Ok((Source::Text { file: open()?, form: form.clone(), line: 0 }, form))
}

/// The lines that tell how a file is written.
fn head(file: &mut BufReader<File>, path: &Path, declared: &TextForm) -> Result<Vec<String>, RigError> {
    let (mut lines, most) = (Vec::new(), HEAD.saturating_add(declared.header_lines.unwrap_or(0)));
    while lines.len() < most
        && let Some(line) = next_line(file, path, lines.len() + 1)?
    {
        lines.push(line);
    }
    Ok(lines)
}

/// A WAV file at its first sample: the largest of its integers, its channels, its sampling rate.
fn wav(path: &Path) -> Result<(Source, Option<f64>, usize, f64), RigError> {
    let WavHeader { spec, frames, samples: file } = header(path)?;
    let unreadable = |reason| RigError::invalid(path, "header", Problem::BadWav { reason });
    let (decode, largest) = pcm(spec).ok_or_else(|| {
        unreadable(format!("{} bit {:?} samples", spec.bits_per_sample, spec.sample_format))
    })?;
    let width = usize::from(spec.channels);
    if width == 0 {
        return Err(unreadable("no channels".into()));
    }
    let sample = usize::from(spec.bits_per_sample / 8);
    let source = Source::Wav { file, decode, sample, stride: width * sample, frames, read: 0 };
    Ok((source, largest, width, f64::from(spec.sample_rate)))
}
