//! What is known of the noise of a record before it is fitted: from its silence, from what a first fit
//! leaves, or from its end.

use super::diagnosis;
use super::fairest::APART_HZ;
use super::from_start::{Start, fit_whitened};
use super::heard::Heard;
use super::judged::Fitted;
use super::options::PingOptions;
use super::resolution::deviation;
use super::ringing;
use super::silence::MIN_QUIET;
use super::whitened::{Noise, Whitened};
use crate::dsp::noise::{MAX_HARMONIC, Whitener, remove_hum};
use crate::{Fault, Trace};
use rijke_numerics::C64;

/// With fewer samples of the quiet part than these the colour of the noise is learnt from the residuals of a
/// first fit, too: from a few hundred it is known so badly that intervals cover 88 % instead of 95 %.
const SHORT_QUIET: usize = 1500;
/// Variance of the residuals, over that of the noise as measured, up to which they count as noise.
const NOISE_ALONE: f64 = 1.3;

/// The noise that a silence holds.
pub(super) fn noise_heard(trace: &Trace<'_>, options: &PingOptions, heard: Heard) -> Result<Noise, Fault> {
    let Heard { noise, harmonics, tones, narrow_hz } = heard;
    let quiet = noise.first().map_or(0, Vec::len);
    if let Some(hz) = narrow_hz {
        // A filter learnt from it would take the mode for noise.
        let deviations: Vec<f64> =
            noise.iter().map(|y| ringing::calm_deviation(y, trace.rate_hz, hz)).collect();
        return Ok(Noise {
            whitener: Whitener::scaling(&deviations),
            harmonics,
            tones,
            silence: noise,
            narrow_hz,
        });
    }
    let learnt = if quiet < SHORT_QUIET {
        let deviations: Vec<f64> = noise.iter().map(|y| deviation(y)).collect();
        // A fit that leaves more than noise says nothing of its colour: a filter learnt from it would
        // take the mode for noise.
        let scaling = Whitener::scaling(&deviations);
        let learnt = learn_from_residuals(trace, options, scaling, (&harmonics, &tones)).ok();
        learnt.filter(|(_, left)| *left < NOISE_ALONE).map(|(whitener, _)| whitener)
    } else {
        None
    };
    let whitener = learnt.map_or_else(|| Whitener::learn(&noise), Ok)?;
    Ok(Noise { whitener, harmonics, tones, silence: noise, narrow_hz })
}

/// A first notion of the noise of a record without silence, from its last tenth: the colour, if the mode does
/// not ring there any more, and the harmonics of the mains, but for those beside the mode, which may ring.
pub(super) fn noise_at_the_end(trace: &Trace<'_>, options: &PingOptions) -> (Whitener, Vec<u32>) {
    let tail = trace.len() - trace.len() / 10;
    let mut end: Vec<Vec<f64>> = trace.channels.iter().map(|y| y[tail..].to_vec()).collect();
    let deviations: Vec<f64> = end.iter().map(|y| deviation(y)).collect();
    let white = Whitener::scaling(&deviations);
    let Some(hz) = diagnosis::loudest(trace, options) else { return (white, Vec::new()) };
    let beside = |h: &u32| (f64::from(*h) * options.mains_hz - hz).abs() < APART_HZ;
    let beside: Vec<u32> = (1..=MAX_HARMONIC).filter(beside).collect();
    let harmonics = remove_hum(&mut end, trace.rate_hz, options.mains_hz, &beside);
    let calm = trace.len() - tail >= MIN_QUIET && !ringing::rings(&end, trace.rate_hz, hz);
    let learnt = calm.then(|| Whitener::learn(&end).ok()).flatten();
    (learnt.unwrap_or(white), harmonics)
}

/// With little or no quiet part: fit with a first notion of the noise, learn its colour from what is left,
/// for another fit. And the variance of what is left, over that of the noise as measured.
pub(super) fn learn_from_residuals(
    trace: &Trace<'_>,
    options: &PingOptions,
    whitener: Whitener,
    (harmonics, tones): (&[u32], &[f64]),
) -> Result<(Whitener, f64), Fault> {
    let noise = Noise { tones: tones.to_vec(), ..Noise::of(whitener, harmonics.to_vec()) };
    let record = Whitened::of(trace, options, &noise)?;
    let fit = |start| fit_whitened(trace, options, &record, 0.0, start);
    let sound = |fit: &Fitted| fit.solution.variance() < NOISE_ALONE;
    let found = match fit(Start::Plateau) {
        Ok(found) if sound(&found) => found,
        first => match fit(Start::Backwards) {
            Ok(found) if sound(&found) => found,
            _ => first?,
        },
    };
    let variance = found.solution.variance();
    let Some(left) = noise_left(trace, &found) else { return Ok((noise.whitener, variance)) };
    Ok((Whitener::learn(&left)?, variance))
}

/// What a fit leaves of the record as it stands, not whitened; none where a filter and a curve of the mode
/// come together.
fn noise_left(trace: &Trace<'_>, found: &Fitted) -> Option<Vec<Vec<f64>>> {
    let channels = trace.channels.len();
    if found.whitener.order() == 0 {
        let (left, scales) = (found.residuals(), found.whitener.deviations(0.0, found.step));
        let unscaled = |(m, d): (usize, &f64)| left.iter().skip(m).step_by(channels).map(|v| v * d).collect();
        return Some(scales.iter().enumerate().map(unscaled).collect());
    }
    if found.solution.components[0].is_curved() {
        return None;
    }
    let (from, to) = (found.offset + found.rows.0, found.offset + found.rows.1);
    let mut left: Vec<Vec<f64>> = trace.channels.iter().map(|y| y[from..to].to_vec()).collect();
    for (component, white) in found.solution.components.iter().zip(&found.solution.amplitudes) {
        let (unwhiten, _) = found.whitener.unwhiten(component.s, found.step);
        let turn = (component.s * found.step).exp();
        for (y, row) in left.iter_mut().zip(&unwhiten) {
            let mut wave: C64 = row.iter().zip(white).map(|(u, b)| u * b).sum();
            for v in y {
                *v -= wave.re;
                wave *= turn;
            }
        }
    }
    Some(left)
}
