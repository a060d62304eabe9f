//! Decay rate, frequency and mode shape of one ring-down, with covariance and verdict.

use super::backwards::last_decay;
use super::chirp::Drift;
use super::diagnosis;
use super::driven;
use super::excess::Excesses;
use super::fairest::{self, APART_HZ, has_close_neighbour};
use super::forcing::{Change, Envelope};
use super::found::PingFit;
use super::heard::{Heard, beside_a_tone};
use super::judged::Fitted;
use super::options::PingOptions;
use super::power;
use super::resolution::{self, deviation};
use super::rest::{Disagreement, at_rest};
use super::ringing::{self, Ringing};
use super::search::Search;
use super::silence;
use super::verdict;
use crate::dsp::noise::{MAX_HARMONIC, Whitener, remove_hum};
use crate::ringdown::{Component, Kind, SEARCHING, SETTLING, Solution, White};
use crate::{Fault, Trace};
use rijke_numerics::C64;

/// Fewest samples of the quiet part from which the noise is learnt; with fewer, it is learnt from residuals.
pub(super) const MIN_QUIET: usize = 256;
/// With fewer samples of the quiet part than these the colour of the noise is learnt from the residuals of a
/// first fit, too: from a few hundred it is known so badly that intervals cover 88 % instead of 95 %.
const SHORT_QUIET: usize = 1500;
/// Variance of the residuals, over that of the noise as measured, up to which they count as noise.
const NOISE_ALONE: f64 = 1.3;
/// The first part of the decay in which neighbours are sought, s: they die away sooner than the mode of
/// interest, and a longer stretch would bury them in noise.
const EARLY: f64 = 0.25;
/// Fewest decay times, unless there is so much time, s: a stretch of forcing with a little decay at its end
/// looks like a slow decay.
const LEAST_DECAY: f64 = 0.7;
const LEAST_TIME: f64 = 0.5;

/// Fits one ring-down by maximum likelihood.
///
/// The record holds an optional quiet part (noise alone), optional steady forcing near the mode, and the free
/// decay; the end of forcing is found from the record. Equal samples to the end of the record in all channels
/// are cut off, and a constant offset of a channel is taken away first.
/// All channels share every complex frequency; each channel has its own complex amplitudes. Noise is whitened
/// with its colour and correlation between channels as learnt from the quiet part (Gaussian, stationary: hum
/// is fitted apart). The covariance is the inverse Fisher information, scaled with the residual variance.
/// Cost: see `benches/records.rs`.
///
/// # Errors
/// A [`Fault`] that says why the record must not be used.
pub fn fit_ping(trace: &Trace<'_>, options: &PingOptions) -> Result<PingFit, Fault> {
    let cut: Option<Vec<Vec<f64>>> =
        trace.padded_from().map(|end| trace.channels.iter().map(|y| y[..end].to_vec()).collect());
    let trace = &Trace { channels: cut.as_deref().unwrap_or(trace.channels), ..*trace };
    trace.screen(512)?;
    options.check(trace)?;
    let steps = trace.coarse_steps();
    let levelled = trace.levelled(MIN_QUIET);
    let trace = &Trace { channels: levelled.as_deref().unwrap_or(trace.channels), ..*trace };
    let quiet = trace.quiet.min(trace.len());
    silence::check(trace, quiet)?;
    let deviations = if quiet >= MIN_QUIET { resolution::deviations(trace, &steps, quiet)? } else { None };
    let least = if deviations.is_some() { resolution::LEAST } else { 0.0 };
    let noise = if let Some(deviations) = deviations {
        Noise::of(Whitener::scaling(&deviations), Vec::new())
    } else if quiet >= MIN_QUIET {
        let Heard { noise, harmonics, tones, narrow_hz } = Heard::of(trace, options, quiet);
        if let Some(hz) = narrow_hz {
            // A filter learnt from it would take the mode for noise.
            let deviations: Vec<f64> =
                noise.iter().map(|y| ringing::calm_deviation(y, trace.rate_hz, hz)).collect();
            Noise { whitener: Whitener::scaling(&deviations), harmonics, tones, silence: noise, narrow_hz }
        } else {
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
            Noise { whitener, harmonics, tones, silence: noise, narrow_hz }
        }
    } else {
        let (whitener, harmonics) = noise_at_the_end(trace, options);
        Noise::of(learn_from_residuals(trace, options, whitener, (&harmonics, &[]))?.0, harmonics)
    };
    let tones = noise.tones.clone();
    let fit = |noise: &Noise| judged_fit(trace, options, noise, least);
    let found = match fit(&noise) {
        // The pressure may wander slowly, by more than the quiet part shows.
        Err(fault) if diagnosis::is_doubtful(&fault) || matches!(fault, Fault::Weak(_)) => {
            let steady = |hz| noise.whitener.without_wander(hz, trace.rate_hz);
            let steady = diagnosis::loudest(trace, options).map(steady);
            steady.and_then(|whitener| fit(&Noise { whitener, ..noise }).ok()).ok_or(fault)
        }
        found => found,
    };
    found.map_err(|fault| {
        let outside = driven::outside(trace, options.band_hz, options.mains_hz, &fault);
        let fault = outside.unwrap_or_else(|| diagnosis::reason(trace, options, fault));
        let fault = driven::or_all_the_time(trace, fault);
        beside_a_tone(fault, &tones, diagnosis::loudest(trace, options))
    })
}

/// A first notion of the noise of a record without silence, from its last tenth: the colour, if the mode does
/// not ring there any more, and the harmonics of the mains, but for those beside the mode, which may ring.
fn noise_at_the_end(trace: &Trace<'_>, options: &PingOptions) -> (Whitener, Vec<u32>) {
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

/// The fit from the end of the plateau, or, if that is doubtful or fails, from the last decay.
fn judged_fit(trace: &Trace<'_>, options: &PingOptions, noise: &Noise, least: f64) -> Result<PingFit, Fault> {
    let fit = |start| fit_whitened(trace, options, noise, least, start);
    let plateau = fit(Start::Plateau);
    let doubtful = plateau.as_ref().is_ok_and(|fit| fit.doubtful);
    let backwards = || fit(Start::Backwards)?.judged(options);
    match plateau.and_then(|fit| fit.judged(options)) {
        // A later start is right if the forcing went on, and not if two modes decay all the while.
        Ok(found) if doubtful => match backwards() {
            Ok(later) if later.skipped_s == 0.0 => Ok(later),
            _ => Ok(found),
        },
        Err(fault) if diagnosis::is_doubtful(&fault) => match backwards() {
            // A decay that was found, and in which the channels differ, says more.
            Err(apart @ (Fault::GainDrifts { .. } | Fault::GainsApart { .. })) => Err(apart),
            found => found.or(Err(fault)),
        },
        result => result,
    }
}

/// What is known of the noise before a fit.
struct Noise {
    whitener: Whitener,
    /// Harmonics of the mains that the record holds.
    harmonics: Vec<u32>,
    /// Steady tones beside the mode that it holds, Hz.
    tones: Vec<f64>,
    /// The quiet part without them; nothing if it is too short.
    silence: Vec<Vec<f64>>,
    /// The frequency at which it rings, Hz.
    narrow_hz: Option<f64>,
}

impl Noise {
    fn of(whitener: Whitener, harmonics: Vec<u32>) -> Self {
        Self { whitener, harmonics, tones: Vec::new(), silence: Vec::new(), narrow_hz: None }
    }
}

/// How the start of the decay is found.
#[derive(Clone, Copy)]
enum Start {
    /// At the end of a plateau that the record holds.
    Plateau,
    /// From the end of the record: see [`last_decay`].
    Backwards,
}

/// With little or no quiet part: fit with a first notion of the noise, learn its colour from what is left,
/// for another fit. And the variance of what is left, over that of the noise as measured.
fn learn_from_residuals(
    trace: &Trace<'_>,
    options: &PingOptions,
    whitener: Whitener,
    (harmonics, tones): (&[u32], &[f64]),
) -> Result<(Whitener, f64), Fault> {
    let noise = Noise { tones: tones.to_vec(), ..Noise::of(whitener, harmonics.to_vec()) };
    let fit = |start| fit_whitened(trace, options, &noise, 0.0, start);
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

fn fit_whitened(
    trace: &Trace<'_>,
    options: &PingOptions,
    noise: &Noise,
    least_amplitude: f64,
    start: Start,
) -> Result<Fitted, Fault> {
    let Noise { whitener, harmonics, tones, silence, narrow_hz } = noise;
    let (channels, step) = (trace.channels.len(), 1.0 / trace.rate_hz);
    let quiet = trace.quiet.min(trace.len());
    let samples = whitener.apply(trace.channels, quiet, trace.len());
    let white = White { samples: &samples, channels, step };
    let mut envelope = Envelope::new(white, options.band_hz)?;
    let silence = whitener.apply(silence, 0, silence.first().map_or(0, Vec::len));
    let quietness = White { samples: &silence, channels, step };
    let power = narrow_hz.map_or(0.0, |hz| ringing::power_at(quietness, hz));
    let ringing = if power > 0.0 { envelope.ringing(power, step) } else { Ringing::default() };
    let mut search = Search { options, harmonics, tones, ringing };
    let need = 10 * envelope.block;
    let early = |from: usize| white.slice(from, from + (EARLY / step) as usize);
    let too_short = |first: usize| Fault::ShortDecay {
        have: white.rows().saturating_sub(first) as f64 * step,
        need: need as f64 * step,
        frequency_hz: envelope.omega / std::f64::consts::TAU,
    };
    let safe = envelope.safe_start();
    // A tail shorter than this cannot be told from forcing that fades.
    if white.rows() < safe + need && envelope.regrowth().is_none() {
        return Err(too_short(safe));
    }
    let order = whitener.order();
    let (end, rough, subspace, decays_from) = match start {
        Start::Plateau => {
            if let Some(growth) = envelope.regrowth() {
                let row = |block: usize| block * envelope.block;
                let at = (quiet + whitener.order() + row(growth.least)) as f64 * step;
                let mode_hz = envelope.omega / std::f64::consts::TAU;
                let (grown, mains_hz) = (row(growth.grown), options.mains_hz);
                return Err(verdict::regrowth(white, mode_hz, grown, at, growth.factor, mains_hz));
            }
            let (components, subspace) = search.first_guess(early(safe))?;
            let rough = search.solve(early(safe), early(safe), components, SEARCHING)?;
            let lag = (2 * envelope.block).saturating_sub(order);
            let end = envelope.decay_start(white, &rough, safe);
            (end.unwrap_or(Change { row: safe.saturating_sub(lag + order), lag }), rough, subspace, None)
        }
        Start::Backwards => {
            let found = last_decay(&search, white, &envelope);
            let found = found.ok_or_else(|| too_short(white.rows()))?;
            let subspace = found.rough.components[0].s;
            (found.end, found.rough, subspace, found.decays_from)
        }
    };
    let end = Change { lag: end.lag + ringing.hides(&rough, step), ..end };
    let from = end.start(order);
    // The earlier start shows neighbours that had died away by the first one.
    let components = search.more_modes(early(from), &rough.components)?;
    let growth_rate = components[0].s.re;
    if growth_rate >= 0.0 {
        return Err(Fault::NotDecaying(growth_rate));
    }
    let mode_hz = components[0].s.im / std::f64::consts::TAU;
    let until = quiet + whitener.order() + from;
    let before: Vec<Vec<f64>> = trace.channels.iter().map(|y| y[quiet..until].to_vec()).collect();
    driven::check(&before, step, mode_hz, options.band_hz, options.mains_hz)?;
    let length = (options.decay_times / (-growth_rate * step)).ceil() as usize;
    let mut to = white.rows().min(from + length.max(need));
    let mut solution = search.solve(white.slice(from, to), early(from), components, SETTLING)?;
    let real = search.real_harmonics(&solution, step)?;
    if real.len() < harmonics.len() {
        search.harmonics = &real;
        let is_real = |c: &Component| !matches!(c.kind, Kind::Mains(h) if !real.contains(&h));
        let components = solution.components.iter().copied().filter(is_real).collect();
        solution = search.solve(white.slice(from, to), early(from), components, SETTLING)?;
    }
    if least_amplitude > 0.0 {
        let loudest = solution.amplitudes[0].iter().map(|a| a.norm()).fold(0.0, f64::max);
        let lasts =
            (loudest / least_amplitude).ln() / (-solution.components[0].s.re * step).max(f64::MIN_POSITIVE);
        to = to.min(from + (lasts.max(0.0) as usize).max(need));
        let part = white.slice(from, to);
        solution = search.solve(part, early(from), solution.components, SETTLING)?;
    }
    let part = white.slice(from, to);
    let noise = ringing.added_to(1.0, channels);
    let rest = |from: usize, solution: &Solution| solution.residuals(white.slice(from, white.rows()), 0.0);
    let mut left = rest(from, &solution);
    let inside = &left[..(to - from) * channels];
    let is_curved = Drift::left_by(&solution, inside, step).is_significant()
        || Excesses::left_by(&solution, inside, step).is_significant();
    let mut rival = None;
    let fit = |components| search.solve(part, early(from), components, SETTLING).ok();
    if fairest::is_doubtful(&solution, noise) || is_curved {
        (solution, rival) = fairest::fairest(part, (noise, ringing), solution, &fit);
        left = rest(from, &solution);
    } else if solution.components[0].is_curved() {
        // What the first part of the decay took for a curve may be two modes in the whole of it.
        let (found, other) = fairest::fairest(part, (noise, ringing), solution.clone(), &fit);
        rival = if has_close_neighbour(&found.components) { Some(found) } else { other };
    }
    if search.ringing.is_some() {
        // A silence of a few decay times may be quieter than the rest.
        let found = power::power(&solution, quietness, Some(White { samples: &left, ..white }));
        search.ringing = search.ringing.at_least(found, solution.components[0].s);
    }
    if let Some(fault) = diagnosis::still_driven(white, &search, &envelope, (from, to), &solution) {
        return Err(fault);
    }
    let have = (to - from) as f64 * step;
    let least = (LEAST_DECAY / -solution.components[0].s.re.min(-f64::MIN_POSITIVE)).min(LEAST_TIME);
    if have < least {
        return Err(Fault::ShortDecay { have, need: least, frequency_hz: mode_hz });
    }
    let time = |row: usize| (quiet + whitener.order() + row) as f64 * step;
    let (begin, own) = (from, diagnosis::has_mode_near_third(&solution));
    let (from, solution) = at_rest(&search, white, (from, to), need, solution).map_err(|found| {
        let Disagreement { rows, growth_rates, distance } = found;
        Fault::NotFree { from: rows.map(time), growth_rates, distance }
    })?;
    if from > begin
        && let Some(fault) = diagnosis::bent(trace, options, own)
    {
        return Err(fault);
    }
    if from > begin {
        left = rest(from, &solution);
    }
    let other_law = solution.components[0].excess.and_then(|_| {
        let mut components = solution.components.clone();
        components[0].law = components[0].law.other();
        search.solve(white.slice(from, to), early(from), components, SETTLING).ok()
    });
    Ok(Fitted {
        whitener: whitener.clone(),
        harmonics: search.harmonics.to_vec(),
        silence,
        ringing: search.ringing,
        learnt_from: if quiet >= MIN_QUIET { quiet } else { white.rows() },
        channels,
        step,
        offset: quiet + whitener.order(),
        rows: (from, to),
        end,
        decays_from,
        guess: subspace,
        doubtful: has_close_neighbour(&solution.components) || envelope.falls_late(channels, step),
        other_law: other_law.filter(|found| found.components[0].excess.is_some()),
        solution,
        rival,
        left,
    })
}
