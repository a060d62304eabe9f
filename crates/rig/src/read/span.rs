//! The part of a long record that a measurement needs, so that a record may be larger than memory: found in a
//! first pass over the file, taken in a second.

use super::blocks::{Blocks, is_text};
use super::gather::gather;
use super::layout::Layout;
use super::record::read_record;
use crate::error::RigError;
use crate::records::record::Record;
use std::ops::Range;
use std::path::Path;

/// What a record is a record of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// Forcing that ends and a decay: needed are the quiet part, the last 0.4 s of forcing and the decay
    /// until it is lost in noise.
    Ping,
    /// One impulse: needed is what comes from the quiet part until 0.1 s after the loudest moment.
    Click,
}

/// Frames up to which a record is read as it is.
const LONG: usize = 1 << 18;
/// Frames of the quiet part that are kept of a long record.
const QUIET: usize = 1 << 14;
/// Frames whose energy is one number of the survey.
const STRETCH: usize = 256;

/// Reads one record as [`read_record`] does; of a WAV or text file of more than 262 144 frames only what the
/// event needs. Then the end of the quiet part is kept, and a ping has a seam behind it as if the recorder
/// had skipped to the last part of the forcing. Memory: that part, 0.03 bytes per frame of the file, and one
/// block of 4096 frames. Other formats are read as a whole.
///
/// # Errors
/// Those of [`read_record`].
pub fn read_event(path: &Path, layout: Layout<'_>, event: Event) -> Result<Record, RigError> {
    if !is_text(path) && crate::formats::arrays::is_file_of_arrays(path)? {
        return read_record(path, layout);
    }
    if Blocks::open(path, layout)?.most_frames()? <= LONG {
        return read_record(path, layout);
    }
    let survey = Survey::of(path, layout)?;
    if survey.frames <= layout.quiet {
        return read_record(path, layout);
    }
    let kept = layout.quiet.min(QUIET);
    let quiet = layout.quiet - kept..layout.quiet;
    let needed = match event {
        Event::Ping => survey.decay(layout),
        Event::Click => survey.impulse(layout),
    };
    gather(path, layout, &[quiet, needed], kept)
}

/// The energy of a record, stretch by stretch, without its mean: what is known of it without holding it.
struct Survey {
    frames: usize,
    energy: Vec<f64>,
}

impl Survey {
    fn of(path: &Path, layout: Layout<'_>) -> Result<Self, RigError> {
        let (mut blocks, mut block) = (Blocks::open(path, layout)?, Vec::new());
        let (mut frames, mut energy) = (0, Vec::new());
        loop {
            let count = blocks.next(&mut block)?;
            if count == 0 {
                return Ok(Self { frames, energy });
            }
            frames += count;
            for stretch in block.chunks(STRETCH * blocks.width) {
                let rows = (stretch.len() / blocks.width) as f64;
                let of = |c: usize| {
                    let column = || stretch.iter().skip(c).step_by(blocks.width);
                    let mean = column().sum::<f64>() / rows;
                    column().map(|p| (p - mean).powi(2)).sum::<f64>() / rows
                };
                energy.push(blocks.plan.takes.iter().map(|t| t.scale.powi(2) * of(t.column)).sum());
            }
        }
    }

    /// From the last forcing to the end of the decay: where the energy has come down to the noise, or to
    /// 1e-8.
    fn decay(&self, layout: Layout<'_>) -> Range<usize> {
        let seconds = |s: f64| (s * layout.rate_hz) as usize;
        let first = layout.quiet.div_ceil(STRETCH).min(self.energy.len());
        let later = &self.energy[first..];
        let top = later.iter().fold(0.0_f64, |a, e| a.max(*e));
        let last = first + later.iter().rposition(|e| *e >= 0.5 * top).unwrap_or(0);
        let floor = self.energy[last..].iter().fold(top, |a, e| a.min(*e));
        let silent = |e: &f64| *e < (1.5 * floor).max(1e-8 * top);
        let length = self.energy[last..].iter().position(silent).unwrap_or(self.energy.len() - last);
        let from = (last * STRETCH).saturating_sub(seconds(0.4)).max(layout.quiet);
        // The mean energy of noise is reached some time before the mode is lost in it.
        let to = (last + 2 * length + 1) * STRETCH + seconds(0.1);
        from..to.min(self.frames)
    }

    fn impulse(&self, layout: Layout<'_>) -> Range<usize> {
        let first = (layout.quiet / STRETCH).min(self.energy.len());
        let later = self.energy[first..].iter().enumerate();
        let loudest = later.max_by(|a, b| a.1.total_cmp(b.1)).map_or(first, |(k, _)| first + k);
        let to = (loudest + 1) * STRETCH + (0.1 * layout.rate_hz) as usize;
        layout.quiet..to.min(self.frames)
    }
}
