//! Reads some ranges of the frames of a file as one record.

use super::blocks::Blocks;
use super::clock::Clock;
use super::layout::Layout;
use super::plan::Take;
use crate::error::RigError;
use crate::problem::Problem;
use crate::records::record::Record;
use std::ops::Range;
use std::path::Path;

/// Every frame.
pub(crate) const ALL: [Range<usize>; 1] = [0..usize::MAX; 1];

/// The frames of some ranges, ascending, as a record with a quiet part of so many frames.
pub(crate) fn gather(
    path: &Path,
    layout: Layout<'_>,
    ranges: &[Range<usize>],
    quiet: usize,
) -> Result<Record, RigError> {
    let wrong = |place: String, problem| RigError::invalid(path, place, problem);
    let (mut blocks, mut block) = (Blocks::open(path, layout)?, Vec::new());
    let mut channels = vec![Vec::new(); layout.microphones()];
    let mut clock = blocks.plan.time.clone().map(|(column, unit)| (column, Clock::new(unit, layout.rate_hz)));
    let timed = |problem| wrong("time".into(), problem);
    let mut frames = 0;
    loop {
        let count = blocks.next(&mut block)?;
        if count == 0 {
            break;
        }
        let width = blocks.width;
        if let Some((column, clock)) = &mut clock {
            block.iter().skip(*column).step_by(width).try_for_each(|t| clock.see(*t)).map_err(timed)?;
        }
        for &Take { column, microphone, scale, .. } in &blocks.plan.takes {
            let column = || block.iter().skip(column).step_by(width).map(|p| p * scale);
            if let Some((n, value)) = column().enumerate().find(|(_, p)| !p.is_finite()) {
                let problem = Problem::NotFinite { sample: frames + n, value };
                return Err(wrong(format!("microphone {microphone}"), problem));
            }
            for range in ranges {
                let from = range.start.clamp(frames, frames + count) - frames;
                let to = range.end.clamp(frames, frames + count) - frames;
                channels[microphone].extend(column().take(to).skip(from));
            }
        }
        frames += count;
    }
    if let Some((_, clock)) = &clock {
        clock.end().map_err(timed)?;
    }
    if frames <= layout.quiet {
        return Err(wrong("samples".into(), Problem::TooShort { have: frames, quiet: layout.quiet }));
    }
    Ok(Record { rate_hz: layout.rate_hz, quiet, full_scale: blocks.full_scale, channels })
}
