//! The last free decay of a record in which two modes beat: their sum grows while both decay, so that neither
//! a plateau nor a short window tells where the forcing ends.
//!
//! From any moment of the decay to the end of the record the same modes explain all of it. A stretch that
//! begins within the forcing is not explained so: no decay goes on like a steady tone and stops. From the end
//! of the record the stretch grows towards its beginning as long as decaying modes, two of them close, leave
//! no more than noise of all of it.

use super::backwards::{FADES, LENGTH, LastDecay, MISSES, STRIDE, before, explains};
use super::fairest::is_close;
use super::forcing::Envelope;
use super::search::Search;
use crate::ringdown::{Component, SEARCHING, Solution, White};
use std::f64::consts::TAU;

/// Amplitude over the noise, in all channels together, that the weaker of two modes must have: a fainter one
/// may be noise that rings the other, of which a short silence shows little.
const LOUD: f64 = 30.0;

/// The last free decay of `white` in which two modes beat, and their frequencies, Hz; the decay only where
/// a single forcing precedes it. Two modes of amplitudes 1 and r, d apart, beat where |1 + r e^{i d t}|
/// e^{-a t} grows for a time: where r d exceeds a. A loudspeaker that goes on is none of them: it does not
/// decay as a mode does.
pub(super) fn last_beats(
    search: &Search<'_>,
    white: White<'_>,
    envelope: &Envelope,
) -> Option<(Option<LastDecay>, [f64; 2])> {
    if search.ringing.is_some() {
        return None;
    }
    let rows = |seconds: f64| (seconds / white.step) as usize;
    let block = envelope.block;
    let stride = rows(STRIDE).max(2 * block);
    let (first, last) = envelope.loud(white.channels)?;
    let onset = first * block;
    let length = rows(LENGTH).max(10 * block);
    let to = white.rows().min((last + 1) * block + length);
    let mut start = to.checked_sub(length)?;
    let mut decays: Vec<(usize, Solution)> = Vec::new();
    let mut missed = 0;
    while missed < MISSES {
        let (window, early) = (white.slice(start, to), white.slice(start, start + length));
        let fit = |components: Vec<Component>| {
            let found = search.solve(window, early, components, SEARCHING).ok()?;
            (found.components[0].s.re < 0.0 && explains(search, window, &found)).then_some(found)
        };
        let again = decays.last().and_then(|(_, known)| fit(known.components.clone()));
        let found = again.or_else(|| fit(search.first_guess(early).ok()?.0));
        match found {
            Some(found) => {
                decays.push((start, found));
                missed = 0;
            }
            None if decays.is_empty() => {}
            None => missed += 1,
        }
        if start <= onset {
            break;
        }
        start = start.saturating_sub(stride).max(onset);
    }
    let (from, rough) = decays.pop()?;
    let mode = rough.components[0];
    let place = (1..rough.components.len()).find(|k| is_close(&rough.components[*k], &mode))?;
    let other = rough.components[place];
    let size = |k: usize| rough.amplitudes[k].iter().map(|b| b.norm_sqr()).sum::<f64>().sqrt();
    let (weak, strong) = (size(place).min(size(0)), size(place).max(size(0)));
    let rates = [mode, other].map(|c| -c.s.re);
    let (slow, fast) = (rates[0].min(rates[1]), rates[0].max(rates[1]));
    let grows = weak * (mode.s.im - other.s.im).abs() > fast * strong;
    if !grows || slow < FADES * fast || weak < LOUD {
        return None;
    }
    let mut hertz = [mode, other].map(|c| c.s.im / TAU);
    hertz.sort_by(f64::total_cmp);
    let whole = from > onset + stride;
    let decay = whole.then(|| before(search, white, (from, onset, stride, block), rough, decays.pop()));
    Some((decay.flatten(), hertz))
}
