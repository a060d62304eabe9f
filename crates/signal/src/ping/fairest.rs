//! A chirp, an excess of damping or a second mode: which of them a decay holds that one mode does not
//! explain.
//!
//! A frequency that drifts during the decay looks like two modes close together, as does a damping that
//! depends on the amplitude, and two modes look like these. Of the fits with and without them, that of most
//! likelihood counts, each free number at a price of half the logarithm of the number of samples (Schwarz,
//! Ann. Statist. 6 (1978) 461).

use super::excess::Excesses;
use super::jump::{self, Jump, Smooth};
use super::ringing::Ringing;
use crate::ringdown::{Component, Kind, Law, Solution, White, glance};
use rijke_numerics::C64;
use std::f64::consts::TAU;

/// A jump, and the fit by one mode that it is a jump of.
pub(super) type Jumped = Box<(Jump, Solution)>;

/// Distance from every known component, Hz, at which a further tone is sought: nearer ones are what the first
/// guess is for.
pub(crate) const APART_HZ: f64 = 12.0;
/// Standard deviations of the residual variance beyond which something is left to explain.
const LEFT: f64 = 4.0;

/// Share of its price that one step must foresee a free number to be worth, or no fit is made with it.
const PROMISE: f64 = 0.5;

/// Distances at which a second mode is tried beside one whose decay no single mode explains, Hz: nearer
/// than the first guess tells them apart in the part of the record that it sees.
const SPLIT_HZ: [f64; 4] = [-2.0, -0.8, 0.8, 2.0];

/// What a jump takes: its size, its phase and its moment.
const NUMBERS: usize = 3;

/// Deviations of what free numbers explain by chance beyond which a second mode explains more.
const CHANCE: f64 = 5.0;

/// Whether a fit may be of the wrong kind: it has a mode close to the first one, or leaves more than noise of
/// the given variance.
pub(super) fn is_doubtful(found: &Solution, noise: f64) -> bool {
    let excess = LEFT * (2.0 / found.freedom.max(1.0)).sqrt();
    has_close_neighbour(&found.components) || found.variance() > (1.0 + excess) * noise
}

/// The fairest fit of `white`, whose noise has the given variance and may ring the mode: `found`, or one
/// that `fit` makes of other components. And, beside a fit by one mode that changes, one by two close modes
/// which explains so much more that chance does not, though not what its many numbers cost.
///
/// # Errors
/// A jump of a fit by one mode that explains more than all of them, and that fit.
pub(super) fn fairest(
    white: White<'_>,
    (noise, ringing): (f64, Ringing),
    found: Solution,
    fit: &dyn Fn(Vec<Component>) -> Option<Solution>,
) -> Result<(Solution, Option<Solution>), Jumped> {
    let with = |list: &[Component], chirp: Option<f64>, excess: Option<(f64, Law)>, close: bool| {
        let far = |(k, c): &(usize, &Component)| *k == 0 || close || !is_close(c, &list[0]);
        let mut list: Vec<Component> = list.iter().enumerate().filter(far).map(|(_, c)| *c).collect();
        (list[0].chirp, list[0].excess) = (chirp, excess.map(|(share, _)| share));
        list[0].law = excess.map(|(_, law)| law).unwrap_or_default();
        list
    };
    let now = &found.components;
    let samples = (white.samples.len().max(2) as f64).ln();
    let chirp = Some(now[0].chirp.unwrap_or(0.0));
    let told = Excesses::is_told(now[0].s.re, white.rows(), white.step);
    let by = |law: Law| told.then(|| (now[0].excess.unwrap_or(0.0), law));
    let excess = by(now[0].law);
    let have = [now[0].chirp.is_some(), now[0].excess.is_some()];
    let foresees = |(chirp, excess): (Option<f64>, Option<(f64, Law)>), price: usize| {
        let gain = glance(white, &with(now, chirp, excess, false)).map_or(0.0, |g| g.gain);
        gain >= PROMISE * price as f64 * samples * found.variance().max(noise)
    };
    let close = has_close_neighbour(now);
    // What both together do not foresee, neither does alone.
    let worth = close || have != [false; 2] || foresees((chirp, excess), 1);
    let mut tried = Vec::new();
    // Those with an excess are those without where none is told.
    let other = by(now[0].law.other());
    let with_excess = [(None, excess), (chirp, excess), (None, other), (chirp, other)];
    let with_excess = with_excess.into_iter().filter(|_| told);
    for curves in std::iter::once((chirp, None)).chain(with_excess).chain([(None, None)]) {
        let has = [curves.0.is_some(), curves.1.is_some()];
        let more = has.iter().zip(have).filter(|(now, before)| **now && !before).count();
        let is_new = has != have || curves.1.is_some_and(|(_, law)| law != now[0].law);
        if close || worth && is_new && foresees(curves, more) {
            tried.push(with(now, curves.0, curves.1, false));
        }
    }
    if close {
        tried.push(with(now, chirp, None, true));
        // The two may lie on both sides of the one.
        tried.push(merged(&found, with(now, chirp, None, false)));
        tried.extend(excess.map(|_| merged(&found, with(now, None, excess, false))));
    }
    if !close && worth && !ringing.is_some() {
        tried.extend(split(white, now));
    }
    let others: Vec<Solution> = tried.into_iter().filter_map(fit).collect();
    let least = others.iter().map(Solution::variance).fold(found.variance(), f64::min).max(noise);
    let chance = ringing.close_energy(white.step);
    let cost = |s: &Solution| {
        let close = s.components.iter().skip(1).filter(|c| is_close(c, &s.components[0])).count() as f64;
        let curves = [s.components[0].chirp, s.components[0].excess].into_iter().flatten().count() as f64;
        (s.residual + chance * (close + 0.5 * curves)) / least + samples * s.numbers() as f64
    };
    let pair = |s: &&Solution| has_close_neighbour(&s.components) && !s.components[0].is_curved();
    let pair = others.iter().filter(pair).min_by(|a, b| a.residual.total_cmp(&b.residual)).cloned();
    let plain = |s: &&Solution| !has_close_neighbour(&s.components) && !s.components[0].is_curved();
    let plain = std::iter::once(&found).chain(&others).filter(plain);
    let plain = plain.min_by(|a, b| a.residual.total_cmp(&b.residual)).filter(|_| !ringing.is_some());
    let jumped = plain.and_then(|plain| {
        let jump = Jump::of(plain, &plain.residuals(white, 0.0), white.step, Smooth::Fitted)?;
        (jump.gain > jump::CLEAR * least).then(|| (jump, plain.clone()))
    });
    let best =
        others.into_iter().fold(found, |best, next| if cost(&next) < cost(&best) { next } else { best });
    let explains = |pair: &Solution| {
        let more = pair.numbers() as f64 - best.numbers() as f64;
        let gain = (best.residual - pair.residual - chance) / least;
        gain > more + CHANCE * (2.0 * more.max(0.0)).sqrt()
    };
    let alone = best.components[0].is_curved() && !has_close_neighbour(&best.components);
    if let Some((jump, plain)) = jumped {
        let left = (plain.residual - jump.gain) / least + samples * (plain.numbers() + NUMBERS) as f64;
        if left + jump::BETTER < cost(&best) {
            return Err(Box::new((jump, plain)));
        }
    }
    let rival = pair.filter(|pair| alone && explains(pair));
    Ok((best, rival))
}

/// The components with two modes in the place of the first one: the pair of which one step promises most.
fn split(white: White<'_>, now: &[Component]) -> Option<Vec<Component>> {
    let pair = |apart_hz: &f64| {
        let mut list = now.to_vec();
        let s = now[0].s;
        list[0] = Component::new(s - C64::new(0.0, 0.25 * TAU * apart_hz), Kind::Mode);
        list.insert(1, Component::new(s + C64::new(0.0, 0.75 * TAU * apart_hz), Kind::Mode));
        let gain = glance(white, &list).ok()?.gain;
        Some((list, gain))
    };
    SPLIT_HZ.iter().filter_map(pair).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(list, _)| list)
}

/// The components with the first one where it and its close neighbours lie on average.
fn merged(found: &Solution, mut components: Vec<Component>) -> Vec<Component> {
    let first = found.components[0];
    let (mut sum, mut weight) = (first.s * 0.0, 0.0);
    for (k, component) in found.components.iter().enumerate() {
        if k == 0 || is_close(component, &first) {
            let size: f64 = found.amplitudes[k].iter().map(|b| b.norm()).sum();
            sum += component.s * size;
            weight += size;
        }
    }
    if weight > 0.0 && sum.re < 0.0 {
        components[0].s = sum / weight;
    }
    components
}

/// Whether another mode lies so close to the first that it may stand for a decay that is not one: a stretch
/// that begins within the forcing.
pub(crate) fn has_close_neighbour(components: &[Component]) -> bool {
    components.iter().skip(1).any(|c| is_close(c, &components[0]))
}

/// Whether a component is a mode so close to the first one.
pub(super) fn is_close(component: &Component, first: &Component) -> bool {
    component.kind == Kind::Mode && (component.s.im - first.s.im).abs() < TAU * APART_HZ
}
