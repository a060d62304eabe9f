//! What is known of the noise of a record before it is fitted: from its silence, from what a first fit
//! leaves, or from its end.

use super::diagnosis;
use super::from_start::{Start, fit_whitened};
use super::heard::{Heard, beside, is_of_harmonic};
use super::judged::Fitted;
use super::options::PingOptions;
use super::resolution::deviation;
use super::ringing;
use super::search::LASTS;
use super::silence::MIN_QUIET;
use super::whitened::{Noise, Whitened};
use crate::dsp::noise::{MAX_HARMONIC, Whitener, remove_hum};
use crate::ringdown::Kind;
use crate::{Fault, Trace};
use rijke_numerics::C64;
use std::f64::consts::TAU;

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
        learnt.filter(|l| l.variance < NOISE_ALONE).map(|l| l.whitener)
    } else {
        None
    };
    let whitener = learnt.map_or_else(|| Whitener::learn(&noise), Ok)?;
    Ok(Noise { whitener, harmonics, tones, silence: noise, narrow_hz })
}

/// The noise of a record without silence. Hum beside the mode, and hum that the end of the record does not
/// show because the mode still rings there, stand out of what a first fit leaves, or keep it from ending.
pub(super) fn noise_without_silence(trace: &Trace<'_>, options: &PingOptions) -> Result<Noise, Fault> {
    let (whitener, harmonics) = noise_at_the_end(trace, options);
    let learn = |harmonics: &[u32]| learn_from_residuals(trace, options, whitener.clone(), (harmonics, &[]));
    let mut learnt = learn(&harmonics);
    let more = match &mut learnt {
        Ok(Learnt { left, hum, .. }) => {
            let left =
                left.as_mut().map(|left| remove_hum(left, trace.rate_hz, options.mains_hz, &harmonics));
            [left.unwrap_or_default(), hum.clone()].concat()
        }
        Err(_) => diagnosis::loudest(trace, options).map_or_else(Vec::new, |hz| beside(options, hz)),
    };
    let mut all = [&harmonics[..], &more].concat();
    all.sort_unstable();
    all.dedup();
    match if more.is_empty() { None } else { learn(&all).ok() } {
        Some(again) => Ok(Noise::of(again.whitener, all)),
        None => Ok(Noise::of(learnt?.whitener, harmonics)),
    }
}

/// A first notion of the noise of a record without silence, from its last tenth: the colour, if the mode does
/// not ring there any more, and the harmonics of the mains, but for those beside the mode, which may ring.
fn noise_at_the_end(trace: &Trace<'_>, options: &PingOptions) -> (Whitener, Vec<u32>) {
    let tail = trace.len() - trace.len() / 10;
    let mut end: Vec<Vec<f64>> = trace.channels.iter().map(|y| y[tail..].to_vec()).collect();
    let deviations: Vec<f64> = end.iter().map(|y| deviation(y)).collect();
    let white = Whitener::scaling(&deviations);
    let Some(hz) = diagnosis::loudest(trace, options) else { return (white, Vec::new()) };
    let harmonics = remove_hum(&mut end, trace.rate_hz, options.mains_hz, &beside(options, hz));
    let calm = trace.len() - tail >= MIN_QUIET && !ringing::rings(&end, trace.rate_hz, hz);
    let learnt = calm.then(|| Whitener::learn(&end).ok()).flatten();
    (learnt.unwrap_or(white), harmonics)
}

/// What a fit tells of the noise.
struct Learnt {
    whitener: Whitener,
    /// Variance of what it leaves, over that of the noise as measured.
    variance: f64,
    /// What it leaves, if that is known.
    left: Option<Vec<Vec<f64>>>,
    /// Harmonics of the mains that it takes for modes.
    hum: Vec<u32>,
}

/// With little or no quiet part: fit with a first notion of the noise, learn its colour from what is left,
/// for another fit.
fn learn_from_residuals(
    trace: &Trace<'_>,
    options: &PingOptions,
    whitener: Whitener,
    (harmonics, tones): (&[u32], &[f64]),
) -> Result<Learnt, Fault> {
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
    let left = noise_left(trace, &found);
    let whitener = match &left {
        Some(left) => Whitener::learn(left)?,
        None => noise.whitener,
    };
    let hum = (1..=MAX_HARMONIC).filter(|h| {
        let near = |s: C64| is_of_harmonic(options, *h, s.im / TAU) && s.re > -LASTS;
        found.solution.components.iter().skip(1).any(|c| c.kind == Kind::Mode && near(c.s))
    });
    Ok(Learnt { whitener, variance, left, hum: hum.collect() })
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
