//! Why a record could not be fitted: what a fit calls a second excitation or a burst of hum may have another
//! cause.

use super::forcing::{Envelope, FORCED, strongest};
use super::options::PingOptions;
use super::search::{Search, floor};
use super::verdict::tone;
use crate::ringdown::{Component, Kind, SEARCHING, White};
use crate::{Fault, Trace};
use rijke_numerics::C64;
use std::f64::consts::TAU;

/// Least share of the forcing that a tone after it must have to be called a leak. Neighbours and drift leave
/// less.
const LEAK: f64 = 2e-3;
/// Share of the forcing below which no decay begins that follows it.
const FAINT: f64 = 0.15;
/// Share of the forcing from which steady hum is called strong, and how alike it must be at both ends of the
/// record.
const STRONG: f64 = 0.3;
const ALIKE: f64 = 0.3;
/// Share of the median channel below which one has no signal, and how much more hum than signal it must have.
const SILENT: f64 = 0.02;
const HUMS: f64 = 3.0;
/// Share of the third harmonic in the forcing that may come of saturation, and the part of that share which
/// it keeps where the amplitude has fallen to a half: a quarter for a cubic law.
const BENT: f64 = 3e-3;
const FALLS: f64 = 0.45;
/// How steady a tone that lasts must be over two stretches, and how much larger than before the forcing.
const STEADY: f64 = 0.1;
const CLEAR: f64 = 5.0;
/// Length of the stretches that are looked at, s.
const SPAN: f64 = 0.08;

/// A tone of the forcing's frequency that lasts through the decay, which lasts from one row to another and
/// has the `modes` with amplitudes.
pub(crate) fn still_driven(
    white: White<'_>,
    search: &Search<'_>,
    envelope: &Envelope,
    (from, to): (usize, usize),
    (modes, amplitudes): (&[Component], &[C64]),
) -> Option<Fault> {
    let (first, last) = envelope.plateau();
    let end = (last * envelope.block).min(from);
    let begin = (first * envelope.block).max(end.saturating_sub((FORCED / white.step) as usize));
    if end < begin + 8 * envelope.block {
        return None;
    }
    let forcing = white.slice(begin, end);
    let omega = strongest(forcing, search.options.band_hz)?;
    let decay = white.slice(from, to);
    let size = |b: &[C64]| b.iter().map(C64::norm_sqr).sum::<f64>().sqrt();
    let squares = (0..white.channels).map(|m| tone(forcing, 0, forcing.rows(), m, omega / TAU).powi(2));
    let forced = squares.sum::<f64>().sqrt();
    // The tone that goes on may have been taken for the mode.
    let share = size(amplitudes) / forced;
    if share < FAINT {
        return Some(Fault::StillDriven { frequency_hz: omega / TAU, share });
    }
    let mut components = modes.to_vec();
    components.insert(1, Component { s: C64::new(0.0, omega), kind: Kind::Tone });
    let found = crate::ringdown::solve(decay, &components, SEARCHING).ok()?;
    let lasts = -found.components[0].s.re * decay.rows() as f64 * white.step;
    let energy = found.energies().ok()?[1];
    let tone_now = found.components[1].s.im;
    // A mode that hardly decays is no leak.
    let apart = 2.0 * TAU / (FORCED.min(forcing.rows() as f64 * white.step));
    if lasts < 1.5
        || (tone_now - omega).abs() > apart
        || energy < 3.0 * floor(white.channels) * found.variance().max(1.0)
    {
        return None;
    }
    let share = size(&found.amplitudes[1]) / forced;
    (share > LEAK).then_some(Fault::StillDriven { frequency_hz: omega / TAU, share })
}

/// A better reason than `fault`, if there is one.
pub(crate) fn reason(trace: &Trace<'_>, options: &PingOptions, fault: Fault) -> Fault {
    let doubtful = matches!(
        fault,
        Fault::SecondExcitation { .. }
            | Fault::HumBurst { .. }
            | Fault::Residual { .. }
            | Fault::NotFree { .. }
            | Fault::NotDecaying { .. }
            | Fault::NotConverged { .. }
            | Fault::Singular(_)
            | Fault::Weak { .. }
    );
    let better = match fault {
        Fault::StillDriven { .. } => bent(trace, options),
        _ if doubtful => {
            hum(trace, options).or_else(|| bent(trace, options)).or_else(|| lasting(trace, options))
        }
        _ => None,
    };
    better.unwrap_or(fault)
}

fn interleaved(trace: &Trace<'_>) -> Vec<f64> {
    (0..trace.len()).flat_map(|n| trace.channels.iter().map(move |y| y[n])).collect()
}

/// The loudest stretch of the record: its first row, the frequency of its strongest tone in the band, Hz.
fn loudest(white: White<'_>, options: &PingOptions, span: usize) -> Option<(usize, f64)> {
    let mut best = (0.0, 0, 0.0);
    let stretches = white.rows() / span;
    for k in 0..stretches {
        let part = white.slice(k * span, (k + 1) * span);
        let Some(omega) = strongest(part, options.band_hz) else { continue };
        let size: f64 = (0..white.channels).map(|m| tone(part, 0, span, m, omega / TAU).powi(2)).sum();
        if size > best.0 {
            best = (size, k * span, omega / TAU);
        }
    }
    (best.0 > 0.0).then_some((best.1, best.2))
}

/// Hum that is strong from the beginning to the end, or the only thing in a channel.
fn hum(trace: &Trace<'_>, options: &PingOptions) -> Option<Fault> {
    let samples = interleaved(trace);
    let white = White { samples: &samples, channels: trace.channels.len(), step: 1.0 / trace.rate_hz };
    let span = (SPAN * trace.rate_hz) as usize;
    let (from, mode_hz) = loudest(white, options, span)?;
    let last = white.rows().checked_sub(span)?;
    let mode: Vec<f64> = (0..white.channels).map(|m| tone(white, from, span, m, mode_hz)).collect();
    let mut sorted = mode.clone();
    sorted.sort_by(f64::total_cmp);
    let median = sorted[sorted.len() / 2];
    let mut strongest: Option<(f64, usize, f64)> = None;
    for channel in 0..white.channels {
        for harmonic in 1..=3 {
            let frequency_hz = options.mains_hz * f64::from(harmonic);
            if (frequency_hz - mode_hz).abs() < 2.0 / SPAN {
                continue;
            }
            let at = |row: usize| tone(white, row, span, channel, frequency_hz);
            let (a, b) = (at(0), at(last));
            if (a - b).abs() > ALIKE * a.max(b) {
                continue;
            }
            let size = 0.5 * (a + b);
            if mode[channel] < SILENT * median && size > HUMS * mode[channel] {
                return Some(Fault::OnlyHum { channel, frequency_hz });
            }
            let share = size / mode[channel];
            if share > STRONG && strongest.is_none_or(|s| share > s.0) {
                strongest = Some((share, channel, frequency_hz));
            }
        }
    }
    strongest.map(|(share, channel, frequency_hz)| Fault::SteadyHum { channel, frequency_hz, share })
}

/// The tone of the forcing, steady at the end of the record, and not there at its beginning.
fn lasting(trace: &Trace<'_>, options: &PingOptions) -> Option<Fault> {
    let samples = interleaved(trace);
    let white = White { samples: &samples, channels: trace.channels.len(), step: 1.0 / trace.rate_hz };
    let span = (SPAN * trace.rate_hz) as usize;
    let (from, frequency_hz) = loudest(white, options, span)?;
    let size = |row: usize| {
        let squares = (0..white.channels).map(|m| tone(white, row, span, m, frequency_hz).powi(2));
        squares.sum::<f64>().sqrt()
    };
    let last = white.rows().checked_sub(span)?;
    let (end, before) = (size(last), size(last.checked_sub(span)?));
    let share = end / size(from);
    let steady = (before / end - 1.0).abs() < STEADY && last > from + 2 * span;
    let silent = trace.quiet >= span && end > CLEAR * size(0);
    (steady && silent && (LEAK..STRONG).contains(&share))
        .then_some(Fault::StillDriven { frequency_hz, share })
}

/// A third harmonic that is lost faster than the mode.
pub(crate) fn bent(trace: &Trace<'_>, options: &PingOptions) -> Option<Fault> {
    let samples = interleaved(trace);
    let white = White { samples: &samples, channels: trace.channels.len(), step: 1.0 / trace.rate_hz };
    let span = (SPAN * trace.rate_hz) as usize;
    let (from, mode_hz) = loudest(white, options, span)?;
    if 3.0 * mode_hz > 0.45 * trace.rate_hz || span < 64 {
        return None;
    }
    let noise = |channel: usize| tone(white, 0, span.min(trace.quiet.max(1)), channel, 3.0 * mode_hz);
    let share = |row: usize, channel: usize| {
        tone(white, row, span, channel, 3.0 * mode_hz) / tone(white, row, span, channel, mode_hz)
    };
    let channel = (0..white.channels).max_by(|&a, &b| share(from, a).total_cmp(&share(from, b)))?;
    let first = tone(white, from, span, channel, mode_hz);
    let mut row = from;
    while tone(white, row, span, channel, mode_hz) > 0.5 * first {
        row += span / 4;
        if row + span > white.rows() {
            return None;
        }
    }
    let (early, late) = (share(from, channel), share(row, channel));
    let clear =
        trace.quiet < span || tone(white, from, span, channel, 3.0 * mode_hz) > CLEAR * noise(channel);
    (clear && early > BENT && late < FALLS * early).then_some(Fault::Saturated { channel, share: early })
}
