//! Decay rate, frequency and mode shape of one ring-down, with covariance and verdict.

use super::backwards::{LastDecay, last_decay};
use super::beating::last_beats;
use super::chirp::Drift;
use super::diagnosis;
use super::driven;
use super::excess::Excesses;
use super::fairest::{self, has_close_neighbour};
use super::forcing::Change;
use super::found::PingFit;
use super::heard::{Heard, beside_a_tone};
use super::judged::Fitted;
use super::learnt::{MIN_QUIET, learn_from_residuals, noise_at_the_end, noise_heard};
use super::lost::lost;
use super::options::PingOptions;
use super::power;
use super::resolution;
use super::rest::{Disagreement, at_rest};
use super::silence;
use super::verdict;
use super::whitened::{Noise, Whitened};
use crate::dsp::noise::Whitener;
use crate::ringdown::{Component, Kind, SEARCHING, SETTLING, Solution, White};
use crate::{Fault, Mishap, Trace};

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
        noise_heard(trace, options, Heard::of(trace, options, quiet))?
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
        let elsewhere = || driven::elsewhere(trace, options.band_hz, options.mains_hz);
        let elsewhere = || diagnosis::is_doubtful(&fault).then(elsewhere).flatten();
        let fault = outside.or_else(elsewhere).unwrap_or_else(|| diagnosis::reason(trace, options, fault));
        let fault = driven::or_all_the_time(trace, fault);
        let silence_s = quiet as f64 / trace.rate_hz;
        beside_a_tone(fault, &tones, (diagnosis::loudest(trace, options), silence_s))
    })
}

/// The fit from the end of the plateau, or, if that is doubtful or fails, from the last decay.
fn judged_fit(trace: &Trace<'_>, options: &PingOptions, noise: &Noise, least: f64) -> Result<PingFit, Fault> {
    let record = Whitened::of(trace, options, noise)?;
    let fit = |start: Start<'_>| fit_whitened(trace, options, &record, least, start);
    let plateau = fit(Start::Plateau);
    let doubtful = plateau.as_ref().is_ok_and(|fit| fit.doubtful);
    let backwards = || fit(Start::Backwards)?.judged(options);
    let missing = || {
        let order = noise.whitener.order();
        let begin = (trace.quiet.min(trace.len()) + order) as f64 / trace.rate_hz;
        lost(&record.search(options), record.white(), &record.envelope, begin, order)
    };
    let beats = || {
        let (decay, hertz) = last_beats(&record.search(options), record.white(), &record.envelope)?;
        let fitted =
            decay.and_then(|decay| fit(Start::Found(&decay)).and_then(|fit| fit.judged(options)).ok());
        Some(fitted.ok_or(Mishap::Beat { hertz }.into()))
    };
    match plateau.and_then(|fit| fit.judged(options)) {
        // A later start is right if the forcing went on, and not if two modes decay all the while.
        Ok(found) if doubtful => match backwards() {
            Ok(later) if later.skipped_s == 0.0 => Ok(later),
            _ => Ok(found),
        },
        // Louder noise is louder wherever the decay begins.
        Err(fault) if diagnosis::is_doubtful(&fault) && !matches!(fault, Fault::Mishap(_)) => {
            if let Some(mishap) = missing() {
                return Err(mishap.into());
            }
            match backwards() {
                // A decay that was found, and in which the channels differ, says more.
                Err(apart @ (Fault::GainDrifts { .. } | Fault::GainsApart { .. })) => Err(apart),
                Ok(found) => Ok(found),
                Err(_) => beats().unwrap_or(Err(fault)),
            }
        }
        result => result,
    }
}

/// How the start of the decay is found.
#[derive(Clone, Copy)]
pub(super) enum Start<'a> {
    /// At the end of a plateau that the record holds.
    Plateau,
    /// From the end of the record: see [`last_decay`].
    Backwards,
    /// Where it was found.
    Found(&'a LastDecay),
}

pub(super) fn fit_whitened(
    trace: &Trace<'_>,
    options: &PingOptions,
    record: &Whitened<'_>,
    least_amplitude: f64,
    start: Start<'_>,
) -> Result<Fitted, Fault> {
    let Whitened { noise: Noise { whitener, harmonics, .. }, envelope, ringing, .. } = record;
    let (channels, step) = (trace.channels.len(), 1.0 / trace.rate_hz);
    let (quiet, ringing) = (trace.quiet.min(trace.len()), *ringing);
    let (white, quietness) = (record.white(), record.quietness());
    let mut search = record.search(options);
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
        Start::Backwards | Start::Found(_) => {
            let own;
            let found = match start {
                Start::Found(found) => found,
                _ => {
                    own = last_decay(&search, white, envelope).ok_or_else(|| too_short(white.rows()))?;
                    &own
                }
            };
            let subspace = found.rough.components[0].s;
            (found.end, found.rough.clone(), subspace, found.decays_from)
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
    if let Some(fault) = diagnosis::still_driven(white, &search, envelope, (from, to), &solution) {
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
        silence: record.silence.clone(),
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
