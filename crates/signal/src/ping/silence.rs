//! Whether the stretch that is said to be silent is.

use crate::trace::about_a_line;
use crate::{Fault, Trace};

/// Fewest samples of the quiet part from which the noise is learnt; with fewer, it is learnt from residuals.
pub(super) const MIN_QUIET: usize = 256;

/// Stretches of the silence that are compared, and the share of them from which the level of silence is
/// learnt: the quietest.
const STRETCHES: usize = 16;
const QUIETEST: usize = 4;
/// Fewest samples of a stretch.
const LEAST: usize = 32;
/// Amplitude over that of silence beyond which a stretch is no silence. Noise with much of 1/f stays below a
/// half of it.
const LOUD: f64 = 4.0;

/// Share of the power of the loudest stretch of the record from which a stretch is no noise that rings the
/// mode: that comes and goes.
const FORCED: f64 = 0.03;

/// Refuses a silence that holds a part of the forcing, and one that is louder than the end of the record:
/// then the forcing begins with the record. `quiet` samples are said to be silent.
pub(crate) fn check(trace: &Trace<'_>, quiet: usize) -> Result<(), Fault> {
    let length = (quiet / STRETCHES).max(LEAST);
    let stretches = quiet / length;
    if stretches < QUIETEST {
        return Ok(());
    }
    let fault = |from: usize, ratio: f64| Fault::NotQuiet {
        stated: quiet,
        found: from,
        at: from as f64 / trace.rate_hz,
        ratio,
    };
    let mut loudest = (1.0, 0);
    let mut beyond_the_end = Vec::new();
    for y in trace.channels {
        let mut powers: Vec<f64> = y[..stretches * length].chunks_exact(length).map(about_a_line).collect();
        let by_time = powers.clone();
        powers.sort_by(f64::total_cmp);
        let silent = powers[QUIETEST / 2];
        let loudest_of_all = y.chunks_exact(length).map(about_a_line).fold(0.0, f64::max);
        let tail: Vec<f64> = y[y.len() - y.len() / 10..]
            .chunks_exact(length.min(y.len() / 10).max(1))
            .map(about_a_line)
            .collect();
        let end = tail.iter().copied().fold(0.0, f64::max);
        let is_forced = |p: f64| p > FORCED * loudest_of_all || p > LOUD * LOUD * end;
        // A silence of a coarse converter may be one number.
        if silent == 0.0 {
            continue;
        }
        if let Some(first) = by_time.iter().position(|p| *p > LOUD * LOUD * silent && is_forced(*p)) {
            let ratio = (powers[stretches - 1] / silent).sqrt();
            if ratio > loudest.0 {
                loudest = (ratio, first.saturating_sub(1) * length);
            }
        }
        let end = tail.iter().fold(f64::INFINITY, |a, b| a.min(*b));
        let silent = if silent > FORCED * loudest_of_all { silent } else { 0.0 };
        beyond_the_end.push((silent / end.max(f64::MIN_POSITIVE)).sqrt());
    }
    if loudest.1 > 0 || loudest.0 > LOUD {
        return Err(fault(loudest.1, loudest.0));
    }
    beyond_the_end.sort_by(f64::total_cmp);
    match beyond_the_end.get(beyond_the_end.len() / 2) {
        Some(&ratio) if ratio > LOUD => Err(fault(0, ratio)),
        _ => Ok(()),
    }
}
