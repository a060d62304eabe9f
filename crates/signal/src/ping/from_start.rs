//! One ring-down, whitened, from a start of its decay: components, covariance and all that a verdict needs.

use super::backwards::{LastDecay, last_decay};
use super::chirp::Drift;
use super::diagnosis;
use super::driven;
use super::excess::Excesses;
use super::fairest::{self, Jumped, has_close_neighbour};
use super::forcing::Change;
use super::judged::Fitted;
use super::options::PingOptions;
use super::power;
use super::rest::{Disagreement, at_rest};
use super::silence::MIN_QUIET;
use super::verdict;
use super::whitened::{Noise, Whitened};
use crate::ringdown::{Component, Kind, SEARCHING, SETTLING, Solution, White};
use crate::{Fault, Trace};

/// The first part of the decay in which neighbours are sought, s: they die away sooner than the mode of
/// interest, and a longer stretch would bury them in noise.
const EARLY: f64 = 0.25;
/// Fewest decay times, unless there is so much time, s: a stretch of forcing with a little decay at its end
/// looks like a slow decay.
const LEAST_DECAY: f64 = 0.7;
const LEAST_TIME: f64 = 0.5;

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
    let jumps = |jumped: Jumped| {
        let (jump, plain) = &*jumped;
        let at = (quiet + order + from + jump.row) as f64 * step;
        jump.fault(plain.components[0].s, at, step, plain.variance().min(noise))
    };
    let fit = |components| search.solve(part, early(from), components, SETTLING).ok();
    if fairest::is_doubtful(&solution, noise) || is_curved {
        (solution, rival) = fairest::fairest(part, (noise, ringing), solution, &fit).map_err(jumps)?;
        left = rest(from, &solution);
    } else if solution.components[0].is_curved() {
        // What the first part of the decay took for a curve may be two modes in the whole of it.
        let (found, other) =
            fairest::fairest(part, (noise, ringing), solution.clone(), &fit).map_err(jumps)?;
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
