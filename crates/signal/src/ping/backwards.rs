//! The last free decay of a record, found from its end. It needs neither silence nor a plateau before it: the
//! loudspeaker may be switched on within the record, its tone may beat with the modes that this excites, hum
//! may ripple the envelope.
//!
//! From the end of the record a window moves towards its beginning as long as decaying modes (and the mains)
//! explain it to the noise. Where they do so no more, the forcing has ended inside the window. The forcing
//! before must be one: a steady tone together with the same modes, from soon after it begins. Otherwise the
//! record holds more than one excitation.

use super::fairest::has_close_neighbour;
use super::forcing::{Change, Envelope, FORCED, change, forced, strongest};
use super::search::Search;
use super::verdict::Residue;
use crate::ringdown::{Kind, SEARCHING, Solution, White};

/// Distance between windows, and their length, s.
pub(super) const STRIDE: f64 = 0.06;
pub(super) const LENGTH: f64 = 0.25;
/// Deviations by which a mode must decay rather than last.
const DECAYS: f64 = 3.0;
/// Relative difference of amplitude from what the decay after it says, beyond which a stride holds forcing:
/// that is half of it for a mode that decays with 8 1/s. So many deviations of what noise makes of it come on
/// top.
const UNLIKE: f64 = 0.05;
const DOUBT: f64 = 3.0;
/// So many windows in a row must show no decay before the decay has begun after them: near the noise one may
/// fail by chance.
pub(super) const MISSES: usize = 3;
/// So many windows at the end may be too near the noise to say how loud the decay is before them.
const UNSURE: usize = 2;
/// Length of the stretches in which the forcing is compared with its model, s, and share of the largest
/// energy of any stretch that may be left: an interruption that changes the amplitude by a seventh leaves
/// more.
const STRETCH: f64 = 0.02;
const LEFT: f64 = 0.02;
/// The beginning of the forcing may be anything: so long, s, or this share of it.
const BEGINNING: f64 = 0.1;
const SHARE: f64 = 0.2;

/// Share of the mode's decay rate from which on a tone before the decay is no forcing, but another mode that
/// dies away: a loudspeaker may sag, by far less.
pub(super) const FADES: f64 = 0.5;

/// The end of forcing.
pub(crate) struct LastDecay {
    /// Where the forcing ended; the record may begin with the decay.
    pub(crate) end: Change,
    /// A fit of its beginning.
    pub(crate) rough: Solution,
    /// Where what sounds begins, if that is no forcing: a decay in which another mode sounds beside the one
    /// of interest.
    pub(crate) decays_from: Option<usize>,
}

/// What a window shows.
enum Seen {
    Decay(Solution),
    Steady,
    Other,
    Nothing,
}

/// The last free decay of `white`. None if there is no decay at the end, or more than one excitation before.
pub(crate) fn last_decay(search: &Search<'_>, white: White<'_>, envelope: &Envelope) -> Option<LastDecay> {
    let rows = |seconds: f64| (seconds / white.step) as usize;
    let block = envelope.block;
    let stride = rows(STRIDE).max(2 * block);
    let (first, last) = envelope.loud(white.channels)?;
    let onset = first * block;
    let mut start = (last * block).min(white.rows().checked_sub(10 * block)?);
    let mut decays: Vec<(usize, Solution)> = Vec::new();
    let (mut missed, mut anew, mut refuted) = (0, false, false);
    while missed < MISSES {
        let seen = look(search, white.slice(start, start + rows(LENGTH).max(10 * block)));
        let follows = |decays: &[(usize, Solution)]| {
            decays.last().is_none_or(|(later, known)| {
                continues(white.slice(start, *later), known, *later - start, rows(LENGTH))
            })
        };
        let shows_none = matches!(seen, Seen::Steady | Seen::Other);
        match seen {
            Seen::Decay(solution) if follows(&decays) => {
                decays.push((start, solution));
                missed = 0;
            }
            // The first windows may hold too little to be compared with: this one may be the first. Not where
            // a window after it shows no decay: a build-up in noise looks like one as well.
            Seen::Decay(solution) if (1..=UNSURE).contains(&decays.len()) && !anew && !refuted => {
                decays = vec![(start, solution)];
                (missed, anew) = (missed + 1, true);
            }
            // Near the noise nothing may be found yet.
            Seen::Nothing if decays.is_empty() => {}
            _ => missed += 1,
        }
        refuted = missed > 0 && (refuted || shows_none);
        if start <= onset {
            break;
        }
        start = start.saturating_sub(stride).max(onset);
    }
    if anew && decays.len() <= UNSURE {
        return None;
    }
    let (from, rough) = decays.pop()?;
    if from <= onset + stride {
        // The record begins with the decay.
        return Some(LastDecay { end: Change { row: from, lag: 0 }, rough, decays_from: None });
    }
    before(search, white, (from, onset, stride, block), rough, decays.pop())
}

/// The decay whose earliest fit begins at row `from`, and whose `later` one is free of what was before;
/// nothing if no single forcing precedes it.
pub(super) fn before(
    search: &Search<'_>,
    white: White<'_>,
    (from, onset, stride, block): (usize, usize, usize, usize),
    rough: Solution,
    later: Option<(usize, Solution)>,
) -> Option<LastDecay> {
    let rows = |seconds: f64| (seconds / white.step) as usize;
    // A few samples of forcing may hide in the earliest window: the one after it is free of them.
    let (safe, free) = later.unwrap_or((from, rough));
    let end = from - stride;
    let begin = (onset + 3 * block).max(end.saturating_sub(rows(FORCED)));
    if end < begin + 8 * block {
        let decays = is_as_loud(white.slice(onset, safe), &free, end - onset);
        let end = Change { row: end, lag: safe - end };
        return Some(LastDecay { end, rough: free, decays_from: decays.then_some(onset) });
    }
    let stretch = white.slice(begin, end);
    let tone = forced(stretch, strongest(stretch, search.options.band_hz)?, Kind::Mode, &free)?;
    let whole = onset + 3 * block.max(1) + rows(BEGINNING).min((SHARE * (end - onset) as f64) as usize);
    one_forcing(white.slice(whole.min(begin), end), tone.components[0].s.im, &free)?;
    let fades = tone.components[0].s.re < FADES * free.components[0].s.re;
    let end = change(white, (&tone, begin), (&free, safe), end);
    Some(LastDecay { end, rough: free, decays_from: fades.then_some(onset) })
}

fn look(search: &Search<'_>, window: White<'_>) -> Seen {
    let Ok((components, _)) = search.first_guess(window) else { return Seen::Nothing };
    let Ok(solution) = search.solve(window, window, components, SEARCHING) else { return Seen::Other };
    if !explains(search, window, &solution) {
        return Seen::Other;
    }
    // A window that begins within the forcing is explained by a few poles in place of one.
    if has_close_neighbour(&solution.components) {
        return Seen::Other;
    }
    let sd = (solution.variance() * solution.covariance[(0, 0)]).sqrt();
    if -solution.components[0].s.re > DECAYS * sd { Seen::Decay(solution) } else { Seen::Steady }
}

/// Whether a fit leaves no more than noise of a window.
pub(super) fn explains(search: &Search<'_>, window: White<'_>, solution: &Solution) -> bool {
    let left = solution.residuals(window, 0.0);
    let left = search.ringing.taken_out(White { samples: &left, ..window });
    let residue = Residue {
        samples: &left,
        channels: window.channels,
        step: window.step,
        begin: 0.0,
        mode_hz: solution.components[0].s.im / std::f64::consts::TAU,
        narrow: search.ringing.is_some(),
    };
    residue.check(search.options.mains_hz).is_ok()
}

/// Whether a stretch is as loud as the decay after it, which begins `rows` rows later, says: forcing is less
/// loud. A window that begins within the forcing may be explained to the noise by enough modes. The decay was
/// fitted to a window of `length` rows.
fn continues(stretch: White<'_>, known: &Solution, rows: usize, length: usize) -> bool {
    let left = known.residuals(stretch, -(rows as f64));
    let (mut product, mut square) = (0.0, 0.0);
    for (y, left) in stretch.samples.iter().zip(&left) {
        product += (y - left) * y;
        square += (y - left) * (y - left);
    }
    // The growth rate's error acts from the middle of the window to that of the stretch.
    let away = 0.5 * (rows + length) as f64 * stretch.step;
    let of_growth_alone = known.covariance[(0, 0)] * away * away;
    // Amplitudes and growth rate have errors together: hum beside the mode is hardly told from it in a short
    // window.
    let amplitudes = &known.amplitudes[0];
    let strength = known.strength();
    let of_growth = [-0.5 * rows as f64 * stretch.step, 0.0];
    let of_amplitudes = amplitudes.iter().flat_map(|b| [b.re / strength, b.im / strength]);
    let weights: Vec<f64> = of_growth.into_iter().chain(of_amplitudes).collect();
    let of_both = known.mode_covariance(0).quadratic(&weights);
    let doubt = (1.0 / square + known.variance() * of_both.max(of_growth_alone)).sqrt();
    (product / square - 1.0).abs() < UNLIKE + DOUBT * doubt
}

/// Whether a stretch is as loud as `known` says, the decay that follows it, or louder; and not so much less
/// loud as a forcing of its first `forced` rows that was steady, or still rose.
fn is_as_loud(stretch: White<'_>, known: &Solution, forced: usize) -> bool {
    let rows = stretch.rows();
    let left = known.residuals(stretch, -(rows as f64));
    let (mut heard, mut said) = (-(stretch.samples.len() as f64), 0.0);
    for (y, left) in stretch.samples.iter().zip(&left) {
        heard += y * y;
        said += (y - left) * (y - left);
    }
    // Energies of a steady forcing and a decay, over that at the end of the stretch.
    let fall = (-2.0 * known.components[0].s.re * stretch.step).max(f64::MIN_POSITIVE);
    let decay = |rows: usize| (fall * rows as f64).exp_m1() / fall;
    let after = rows - forced;
    let steady = forced as f64 * (fall * after as f64).exp() + decay(after);
    heard / said > 0.5 * (1.0 + steady / decay(rows))
}

/// Something, if one tone, steady or slowly growing or fading, and the modes of `free` are all there is.
fn one_forcing(part: White<'_>, omega: f64, free: &Solution) -> Option<()> {
    let left = forced(part, omega, Kind::Mode, free)?.residuals(part, 0.0);
    let rows = ((STRETCH / part.step) as usize).max(16) * part.channels;
    let energy = |samples: &[f64]| samples.iter().map(|v| v * v).sum::<f64>();
    let largest = part.samples.chunks_exact(rows).map(energy).fold(0.0, f64::max);
    let most = left.chunks_exact(rows).map(energy).fold(0.0, f64::max);
    (most < LEFT * largest + 2.0 * rows as f64).then_some(())
}
