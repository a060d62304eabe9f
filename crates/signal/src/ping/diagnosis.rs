//! Why a record could not be fitted: what a fit calls a second excitation or a burst of hum may have another
//! cause.

mod unstable;

use super::forcing::{Envelope, FORCED, strongest};
use super::options::PingOptions;
use super::search::{Search, floor};
use super::verdict::{loudness, phasors, tones};
use crate::ringdown::{Component, Kind, SEARCHING, Solution, White, glance, solve};
use crate::{Fault, Mishap, Trace};
use rijke_numerics::C64;
use std::f64::consts::TAU;

/// Least share of the forcing that a tone after it must have to be called a leak. Neighbours and drift leave
/// less.
const LEAK: f64 = 2e-3;
/// Share of the energy that a leak must have, up to which one step says that there is none.
const FAR_BELOW: f64 = 0.5;
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
/// Share of an amplitude that it keeps over a quarter of a stretch if it is a forcing's, and that the third
/// harmonic of it keeps; the angle up to which a harmonic is in step with its tone; and the deviations beyond
/// which two frequencies differ.
const HELD: f64 = 0.99;
const HARMONIC_HELD: f64 = 0.9;
const IN_STEP: f64 = 0.3;
const APART: f64 = 4.0;
/// How steady a tone that lasts must be over two stretches, and how much larger than before the forcing.
const STEADY: f64 = 0.1;
const CLEAR: f64 = 5.0;
/// Fewest samples that tell of a tone, and the frequencies at which noise is measured for comparison.
const LEAST_SPAN: usize = 64;
const NEIGHBOURS: u32 = 8;
/// Distance from a multiple of the mains within which a tone may be hum, Hz.
const BESIDE: f64 = 3.0;
/// Length of the stretches that are looked at, s.
const SPAN: f64 = 0.08;

/// A tone of the forcing's frequency that lasts through the decay, which lasts from one row to another and
/// which `known` fits, if the tone explains more than a drift of the frequency does.
pub(crate) fn still_driven(
    white: White<'_>,
    search: &Search<'_>,
    envelope: &Envelope,
    (from, to): (usize, usize),
    known: &Solution,
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
    let forced = loudness(forcing, 0, forcing.rows(), omega / TAU);
    // The tone that goes on may have been taken for the mode.
    let share = size(&known.amplitudes[0]) / forced;
    if share < FAINT {
        return Some(Fault::StillDriven { frequency_hz: omega / TAU, share });
    }
    let mut components = known.components.clone();
    components[0] = Component::new(components[0].s, components[0].kind);
    components.insert(1, Component::new(C64::new(0.0, omega), Kind::Tone));
    let needed = 3.0 * floor(white.channels) + search.ringing.close_energy(white.step);
    if glance(decay, &components).is_ok_and(|g| g.energies[1] + g.gain < FAR_BELOW * needed) {
        return None;
    }
    let found = solve(decay, &components, SEARCHING).ok()?;
    let lasts = -found.components[0].s.re * decay.rows() as f64 * white.step;
    let energy = found.energies().ok()?[1];
    let tone_now = found.components[1].s.im;
    // A mode that hardly decays is no leak.
    let apart = 2.0 * TAU / (FORCED.min(forcing.rows() as f64 * white.step));
    if lasts < 1.5 || (tone_now - omega).abs() > apart || energy < needed * found.variance().max(1.0) {
        return None;
    }
    if found.residual > known.residual {
        return None;
    }
    let share = size(&found.amplitudes[1]) / forced;
    (share > LEAK).then_some(Fault::StillDriven { frequency_hz: omega / TAU, share })
}

/// Whether a record may be sound, or have another fault, although its fit failed so.
pub(crate) fn is_doubtful(fault: &Fault) -> bool {
    matches!(
        fault,
        Fault::SecondExcitation { .. }
            | Fault::HumBurst { .. }
            | Fault::Residual { .. }
            | Fault::NotFree { .. }
            | Fault::StillDriven { .. }
            | Fault::NotDecaying(_)
            | Fault::Mishap(Mishap::Louder { .. })
            | Fault::Unstable(crate::Unstable::GoesOn { .. })
            | Fault::NotConverged { .. }
            | Fault::Singular(_)
    )
}

/// A better reason than `fault`, if there is one.
pub(crate) fn reason(trace: &Trace<'_>, options: &PingOptions, fault: Fault) -> Fault {
    let whole = || Whole::of(trace, options);
    let better = match &fault {
        // What is bent decays otherwise where it is loud.
        Fault::StillDriven { .. } => whole().and_then(|w| w.bent(true).or_else(|| w.growing())),
        Fault::GainDrifts { .. } | Fault::GainsApart { .. } => whole().and_then(|w| w.bent(true)),
        Fault::ShortDecay { .. } => whole().and_then(|w| {
            w.by_itself().or_else(|| w.hum()).or_else(|| w.to_the_end()).or_else(|| w.beside_mains())
        }),
        Fault::Weak(_) => whole().and_then(|w| {
            let steady = || w.by_itself().or_else(|| w.lasting());
            w.hum().or_else(|| w.bent(true)).or_else(steady).or_else(|| w.beside_mains())
        }),
        fault if is_doubtful(fault) => whole().and_then(|w| {
            let unstable = || w.by_itself().or_else(|| w.growing()).or_else(|| w.to_the_end());
            w.hum().or_else(|| w.bent(true)).or_else(unstable).or_else(|| w.lasting())
        }),
        _ => None,
    };
    better.unwrap_or(fault)
}

/// Frequency of the strongest tone in the band where the record is loudest, Hz.
pub(crate) fn loudest(trace: &Trace<'_>, options: &PingOptions) -> Option<f64> {
    Some(Whole::of(trace, options)?.loudest_hz)
}

/// A third harmonic that is lost faster than the mode; `own` says whether a mode lies there.
pub(crate) fn bent(trace: &Trace<'_>, options: &PingOptions, own: bool) -> Option<Fault> {
    Whole::of(trace, options)?.bent(own)
}

/// Whether a mode of its own lies so near three times the frequency of the first one that a stretch does
/// not tell them apart. What a channel that saturates makes of the decay lies there exactly.
pub(crate) fn has_mode_near_third(found: &Solution) -> bool {
    let first = found.components[0].s.im;
    let variance = |k: usize| found.variance() * found.mode_covariance(k)[(1, 1)];
    found.components.iter().enumerate().skip(1).filter(|(_, c)| c.kind == Kind::Mode).any(|(k, c)| {
        let apart = (c.s.im - 3.0 * first).abs();
        apart < 2.0 * TAU / SPAN && apart > APART * (variance(k) + 9.0 * variance(0)).sqrt()
    })
}

/// A record as it stands, and its loudest stretch.
struct Whole<'a> {
    trace: &'a Trace<'a>,
    options: &'a PingOptions,
    /// Row by row.
    samples: Vec<f64>,
    /// Rows of a stretch.
    span: usize,
    /// First row of the loudest one.
    from: usize,
    /// Frequency of its strongest tone in the band, Hz.
    loudest_hz: f64,
}

impl<'a> Whole<'a> {
    /// None for a record in which no stretch has a tone.
    fn of(trace: &'a Trace<'a>, options: &'a PingOptions) -> Option<Self> {
        let samples = (0..trace.len()).flat_map(|n| trace.channels.iter().map(move |y| y[n])).collect();
        let span = ((SPAN * trace.rate_hz) as usize).max(1);
        let mut whole = Self { trace, options, samples, span, from: 0, loudest_hz: 0.0 };
        (whole.from, whole.loudest_hz) = whole.loudest()?;
        Some(whole)
    }

    fn white(&self) -> White<'_> {
        let step = 1.0 / self.trace.rate_hz;
        White { samples: &self.samples, channels: self.trace.channels.len(), step }
    }

    /// Amplitude of a tone in each channel of the stretch that begins at `row`.
    fn tones(&self, row: usize, frequency_hz: f64) -> Vec<f64> {
        tones(self.white(), row, self.span, frequency_hz)
    }

    fn loudest(&self) -> Option<(usize, f64)> {
        let (white, span) = (self.white(), self.span);
        let mut best = (0.0, 0, 0.0);
        for from in (0..white.rows() / span).map(|k| k * span) {
            let Some(omega) = strongest(white.slice(from, from + span), self.options.band_hz) else {
                continue;
            };
            let size = loudness(white, from, span, omega / TAU);
            if size > best.0 {
                best = (size, from, omega / TAU);
            }
        }
        (best.0 > 0.0).then_some((best.1, best.2))
    }

    /// Hum that is strong from the beginning to the end, or the only thing in a channel.
    fn hum(&self) -> Option<Fault> {
        let last = self.white().rows().checked_sub(self.span)?;
        let channels = self.trace.channels.len();
        let mode = self.tones(self.from, self.loudest_hz);
        let mut sorted = mode.clone();
        sorted.sort_by(f64::total_cmp);
        let median = sorted[sorted.len() / 2];
        let mut strongest: Option<(f64, usize, f64)> = None;
        let harmonics = [1.0, 2.0, 3.0].map(|h| self.options.mains_hz * h);
        let both = harmonics.map(|hz| [0, last].map(|row| self.tones(row, hz)));
        for channel in 0..channels {
            for (frequency_hz, both) in harmonics.into_iter().zip(&both) {
                if (frequency_hz - self.loudest_hz).abs() < 2.0 / SPAN {
                    continue;
                }
                let [a, b] = [both[0][channel], both[1][channel]];
                if (a - b).abs() > ALIKE * a.max(b) {
                    continue;
                }
                let size = 0.5 * (a + b);
                // A channel without a signal has no hum either.
                if size < CLEAR * self.noise_beside(channel, frequency_hz, last) {
                    continue;
                }
                if mode[channel] < SILENT * median && size > HUMS * mode[channel] {
                    return Some(Fault::OnlyHum { channel: channel.into(), frequency_hz });
                }
                let share = size / mode[channel];
                if share > STRONG && strongest.is_none_or(|s| share > s.0) {
                    strongest = Some((share, channel, frequency_hz));
                }
            }
        }
        strongest.map(|(share, channel, frequency_hz)| Fault::SteadyHum {
            channel: channel.into(),
            frequency_hz,
            share,
        })
    }

    /// Amplitude of the noise beside a frequency in a channel, in the stretch that begins at `row`: the
    /// median of tones on both sides, of which some may be other multiples of the mains.
    fn noise_beside(&self, channel: usize, frequency_hz: f64, row: usize) -> f64 {
        let apart = self.trace.rate_hz / self.span as f64;
        let beside =
            (2..2 + NEIGHBOURS / 2).flat_map(|k| [-1.0, 1.0].map(|side| side * f64::from(k) * apart));
        let beside = beside.map(|away| frequency_hz + away).filter(|hz| *hz > 0.0);
        let mut sizes: Vec<f64> = beside.map(|hz| self.tones(row, hz)[channel]).collect();
        sizes.sort_by(f64::total_cmp);
        sizes.get(sizes.len() / 2).copied().unwrap_or(0.0)
    }

    /// The tone of the forcing, steady at the end of the record, and not there at its beginning.
    fn lasting(&self) -> Option<Fault> {
        let (from, span, frequency_hz) = (self.from, self.span, self.loudest_hz);
        let size = |row: usize| loudness(self.white(), row, span, frequency_hz);
        let last = self.white().rows().checked_sub(span)?;
        let (end, before) = (size(last), size(last.checked_sub(span)?));
        let share = end / size(from);
        let steady = (before / end - 1.0).abs() < STEADY && last > from + 2 * span;
        let quiet = self.trace.quiet;
        // Noise that rings the mode comes and goes.
        let before_all = (0..quiet / span.max(1)).map(|k| size(k * span)).fold(0.0, f64::max);
        let silent = quiet >= span && end > CLEAR * before_all;
        (steady && silent && (LEAK..STRONG).contains(&share))
            .then_some(Fault::StillDriven { frequency_hz, share })
    }

    /// A tone beside a multiple of the mains.
    fn beside_mains(&self) -> Option<Fault> {
        let mains_hz = (self.loudest_hz / self.options.mains_hz).round() * self.options.mains_hz;
        let beside = mains_hz > 0.0 && (self.loudest_hz - mains_hz).abs() < BESIDE;
        beside.then_some(Fault::BesideMains(self.loudest_hz, mains_hz))
    }

    /// The least third harmonic of a channel over three windows of half a stretch in which its tone does not
    /// fall, where that is largest; none if the tone falls everywhere: then nothing was forced. A harmonic
    /// keeps in step with its tone and does not fall where the tone does not; a mode does not do so.
    fn held(&self, channel: usize, mode_hz: f64, loud: f64) -> Option<f64> {
        let (white, step) = (self.white(), self.span / 4);
        let starts = (0..).map(|k| k * step).take_while(|row| row + 2 * step <= white.rows());
        let phasor = |row: usize, hz: f64| phasors(white, row, 2 * step, hz)[channel];
        let both: Vec<[C64; 2]> =
            starts.map(|row| [phasor(row, mode_hz), phasor(row, 3.0 * mode_hz)]).collect();
        let lasts = |share: f64, of: [f64; 3]| of[1] >= share * of[0] && of[2] >= share * of[1];
        let forced = |three: &&[[C64; 2]]| {
            let tone = [0, 1, 2].map(|k| three[k][0].norm());
            tone[0] > 0.5 * loud.max(tone[1]) && lasts(HELD, tone)
        };
        let harmonic = |three: &[[C64; 2]]| {
            let third = [0, 1, 2].map(|k| three[k][1].norm());
            let behind = |k: usize| three[k][1] * three[k][0].conj().powi(3);
            let in_step = (behind(2) * behind(0).conj()).arg().abs() < IN_STEP;
            if in_step && lasts(HARMONIC_HELD, third) {
                third.into_iter().fold(f64::MAX, f64::min)
            } else {
                0.0
            }
        };
        both.windows(3).filter(forced).map(harmonic).reduce(f64::max)
    }

    /// A third harmonic that is lost faster than the mode: in a forcing that holds it, or in a decay that has
    /// no mode of its `own` there.
    fn bent(&self, own: bool) -> Option<Fault> {
        let (from, span, mode_hz, quiet) = (self.from, self.span, self.loudest_hz, self.trace.quiet);
        if 3.0 * mode_hz > 0.45 * self.trace.rate_hz || span < LEAST_SPAN {
            return None;
        }
        let third = self.tones(from, 3.0 * mode_hz);
        let mode = self.tones(from, mode_hz);
        let share = |m: usize| third[m] / mode[m];
        let channel = (0..mode.len()).max_by(|&a, &b| share(a).total_cmp(&share(b)))?;
        let mut row = from;
        while self.tones(row, mode_hz)[channel] > 0.5 * mode[channel] {
            row += span / 4;
            if row + span > self.white().rows() {
                return None;
            }
        }
        let late = self.tones(row, 3.0 * mode_hz)[channel] / self.tones(row, mode_hz)[channel];
        let early = share(channel);
        // Noise, from silence or from the end of the record. At one frequency it is near zero once in a
        // while, at several beside it it is not.
        let rows = self.white().rows();
        let (at, length) =
            if quiet >= LEAST_SPAN { (0, span.min(quiet)) } else { (rows.checked_sub(span)?, span) };
        let of_noise = |k: u32| {
            let hz = 3.0 * mode_hz + f64::from(k) * self.trace.rate_hz / length as f64;
            tones(self.white(), at, length, hz)[channel]
        };
        let noise = (0..NEIGHBOURS).map(|k| of_noise(k).powi(2)).sum::<f64>() / f64::from(NEIGHBOURS);
        let (lasting, window) = match self.held(channel, mode_hz, mode[channel]) {
            Some(held) => (held, span / 2),
            None if !own => {
                // A sudden onset has all frequencies: what the decay holds is in the stretches beside this
                // one, too.
                let beside = (1..=4).filter_map(|k| (from + k * (span / 4)).checked_sub(span / 2));
                let lasting = beside
                    .filter(|row| {
                        row + span <= rows && self.tones(*row, mode_hz)[channel] > 0.5 * mode[channel]
                    })
                    .map(|row| self.tones(row, 3.0 * mode_hz)[channel])
                    .fold(third[channel], f64::min);
                (lasting, span)
            }
            None => return None,
        };
        let clear =
            lasting > (CLEAR * (noise * length as f64 / window as f64).sqrt()).max(BENT * mode[channel]);
        (clear && early > BENT && late < FALLS * early)
            .then_some(Fault::Saturated { channel: channel.into(), share: early })
    }
}
