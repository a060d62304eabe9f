//! Which frequency the loudspeaker drives: what rings after it must be near.

use super::verdict::loudness;
use crate::dsp::transform;
use crate::ringdown::White;
use crate::unstable::Unstable;
use crate::{Fault, Trace};

/// Periods that the forcing must have to be seen as a tone, and share of all energy before the decay that it
/// must have.
const PERIODS: f64 = 10.0;
const SHARE: f64 = 0.5;
/// Distance from the driven frequency, relative to that of the mode, from which another mode was driven. A
/// loudspeaker may be some per cent off.
const FAR: f64 = 0.25;
/// The same for the edges of the band.
const BESIDE: f64 = 0.05;
/// Bins of the spectrum to each side of the largest that count to the tone.
const BINS: usize = 3;
/// Part of the frequency of a ring-down to each side that holds most of its energy.
const WIDE: f64 = 0.1;
/// Length of the stretches in which a tone is compared with itself, s; how many there must be; and the share
/// of its loudest one from which it is as loud in others.
const SPAN: f64 = 0.08;
const LEAST: usize = 6;
const AS_LOUD: f64 = 0.7;

/// Refuses a mode that is not near the tone which holds most of what was recorded before the decay.
pub(crate) fn check(
    before: &[Vec<f64>],
    step: f64,
    mode_hz: f64,
    band_hz: (f64, f64),
    mains_hz: f64,
) -> Result<(), Fault> {
    match tone(before, step) {
        Some(driven_hz)
            if (driven_hz - mode_hz).abs() > FAR * mode_hz && !is_of_the_mains(driven_hz, mains_hz) =>
        {
            Err(Fault::DrivenElsewhere { driven_hz, mode_hz, band_hz })
        }
        _ => Ok(()),
    }
}

/// What to say of a record that cannot be fitted for `fault`, if its tone lies outside the band; where
/// nothing is heard in the band, by however little.
pub(crate) fn outside(trace: &Trace<'_>, band_hz: (f64, f64), mains_hz: f64, fault: &Fault) -> Option<Fault> {
    let driven_hz = tone(&from(trace, trace.quiet), trace.rate_hz.recip())?;
    let beside = if matches!(fault, Fault::Weak(_)) { 0.0 } else { BESIDE };
    let near = ((1.0 - beside) * band_hz.0..=(1.0 + beside) * band_hz.1).contains(&driven_hz);
    let fault = Fault::DrivenOutside { what: "the loudspeaker drives", driven_hz, band_hz };
    (!near && !is_of_the_mains(driven_hz, mains_hz)).then_some(fault)
}

/// What to say of a record in which nothing of the band can be fitted, if most of its sound is at a frequency
/// above the band, as that of a ring-down without forcing is.
pub(super) fn rings_above(trace: &Trace<'_>, band_hz: (f64, f64), mains_hz: f64) -> Option<Fault> {
    let (loud, step) = (from(trace, trace.quiet), trace.rate_hz.recip());
    let driven_hz = line(&loud, step, WIDE)?;
    // Hum is a tone; a decay near a harmonic is none.
    let hums = tone(&loud, step).is_some_and(|hz| is_of_the_mains(hz, mains_hz));
    let fault = Fault::DrivenOutside { what: "most of the sound is at", driven_hz, band_hz };
    (driven_hz > (1.0 + BESIDE) * band_hz.1 && !hums).then_some(fault)
}

/// What to say of a record that cannot be fitted for a doubtful fault, if what rings after the forcing is far
/// from its tone: both beat while the forcing begins.
pub(super) fn elsewhere(trace: &Trace<'_>, band_hz: (f64, f64), mains_hz: f64) -> Option<Fault> {
    let (quiet, step) = (trace.quiet.min(trace.len()), trace.rate_hz.recip());
    let driven_hz = tone(&from(trace, quiet), step)?;
    let span = (SPAN * trace.rate_hz) as usize;
    let stretches = (trace.len() - quiet).checked_div(span)?;
    let size = |k: usize| size(trace, quiet + k * span, span, driven_hz);
    let sizes: Vec<f64> = (0..stretches).map(size).collect();
    let loudest = sizes.iter().copied().fold(0.0, f64::max);
    let last = sizes.iter().rposition(|size| *size > AS_LOUD * loudest)?;
    // The forcing may end within the stretch after this one.
    let after = from(trace, quiet + (last + 2) * span);
    let mode_hz = tone(&after, step)?;
    let inside = (band_hz.0..=band_hz.1).contains(&mode_hz);
    let far = inside && (driven_hz - mode_hz).abs() > FAR * mode_hz && !is_of_the_mains(driven_hz, mains_hz);
    far.then_some(Fault::DrivenElsewhere { driven_hz, mode_hz, band_hz })
}

/// The same fault, or, if the tone that was taken for that of the loudspeaker sounds all the time, that.
pub(super) fn or_all_the_time(trace: &Trace<'_>, fault: Fault) -> Fault {
    match fault {
        Fault::DrivenOutside { driven_hz, band_hz, .. }
        | Fault::DrivenElsewhere { driven_hz, band_hz, .. }
            if lasts(trace, driven_hz) =>
        {
            Unstable::Beside { frequency_hz: driven_hz, band_hz }.into()
        }
        fault => fault,
    }
}

/// Whether a tone is as loud in the silence, if there is any, and in the last third of the record as where it
/// is loudest.
fn lasts(trace: &Trace<'_>, frequency_hz: f64) -> bool {
    let span = (SPAN * trace.rate_hz) as usize;
    if span == 0 || trace.len() < LEAST * span {
        return false;
    }
    let sizes: Vec<f64> =
        (0..trace.len() / span).map(|k| size(trace, k * span, span, frequency_hz)).collect();
    let loudest = sizes.iter().copied().fold(0.0, f64::max);
    let silent = &sizes[..(trace.quiet / span).min(sizes.len())];
    let end = &sizes[sizes.len() - sizes.len() / 3..];
    silent.iter().chain(end).all(|size| *size > AS_LOUD * loudest)
}

/// Amplitude of a tone over all channels, in a stretch of a record.
fn size(trace: &Trace<'_>, row: usize, span: usize, frequency_hz: f64) -> f64 {
    let of = |y: &Vec<f64>| {
        let white = White { samples: y, channels: 1, step: trace.rate_hz.recip() };
        loudness(white, row, span, frequency_hz).powi(2)
    };
    trace.channels.iter().map(of).sum::<f64>().sqrt()
}

/// The channels of a record from a sample on.
fn from(trace: &Trace<'_>, first: usize) -> Vec<Vec<f64>> {
    trace.channels.iter().map(|y| y[first.min(y.len())..].to_vec()).collect()
}

/// Where there is no forcing, hum may be the loudest.
fn is_of_the_mains(frequency_hz: f64, mains_hz: f64) -> bool {
    let harmonic = (frequency_hz / mains_hz).round();
    harmonic > 0.5 && (frequency_hz - harmonic * mains_hz).abs() < 1.0
}

/// The frequency of the tone that holds most of the energy of a stretch, Hz, if one does.
fn tone(channels: &[Vec<f64>], step: f64) -> Option<f64> {
    line(channels, step, 0.0)
}

/// The same for a line that is as wide as this part of its frequency to each side.
fn line(channels: &[Vec<f64>], step: f64, width: f64) -> Option<f64> {
    let squares = |y: &&Vec<f64>| y.iter().map(|v| v * v).sum::<f64>();
    let loudest = channels.iter().max_by(|a, b| squares(a).total_cmp(&squares(b)))?;
    let rows = loudest.len();
    if rows < 64 {
        return None;
    }
    let transform = transform::forward(rows);
    let (mut series, mut spectrum) = (loudest.clone(), transform.make_output_vec());
    transform.process(&mut series, &mut spectrum).ok()?;
    let energy: Vec<f64> = spectrum.iter().map(|z| z.norm_sqr()).collect();
    let (k, _) = energy.iter().enumerate().skip(1).max_by(|a, b| a.1.total_cmp(b.1))?;
    let bins = BINS.max((width * k as f64) as usize);
    let near: f64 = energy[k.saturating_sub(bins).max(1)..(k + bins + 1).min(energy.len())].iter().sum();
    let all: f64 = energy[1..].iter().sum();
    (k as f64 >= PERIODS && near > SHARE * all).then(|| k as f64 / (rows as f64 * step))
}
