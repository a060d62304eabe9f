//! Where the forcing ends and the free decay begins, found from the record itself: for a record that holds a
//! plateau. For others see [`super::backwards`].

use super::ringing::{CHANCE, Ringing};
use crate::Fault;
use crate::dsp::transform;
use crate::ringdown::{Component, Kind, SETTLING, Solution, White, solve};
use rijke_numerics::C64;

/// Energy of a block, relative to the largest, above which it belongs to the forced plateau. Free decay
/// leaves it after 0.08 decay times, early enough to keep most of the record for the first fit.
const PLATEAU: f64 = 0.85;
/// Deviations by which noise may raise the largest block and lower another, and the least threshold that this
/// leaves.
const NOISE: f64 = 2.5;
const LEAST: f64 = 0.3;
/// Deviations of a block's energy beyond which it differs by more than noise, in a record of hundreds of
/// blocks.
const SURELY: f64 = 3.5;
/// Energy of a block, relative to the largest, from which the forcing counts as risen: a second excitation
/// may be four times as loud as the first.
const RISEN: f64 = 0.05;

/// Fewest samples of a block. Where a block is not a whole number of periods, the energy of a steady tone
/// ripples.
const BLOCK: f64 = 20.0;

/// Time over which the fall of the energy is compared, s; energy over that of the noise that is asked for;
/// and the share of a later fall below which the first one is too slow. Neighbours make a fall uneven by a
/// tenth or two.
const FALL: f64 = 0.05;
const FAR: f64 = 1e4;
const SLOW: f64 = 0.5;

/// What the envelope of the strongest tone shows.
#[derive(Clone, Debug)]
pub(crate) struct Envelope {
    /// Angular frequency of the strongest tone, 1/s.
    pub(crate) omega: f64,
    /// Samples per block: one period, or a few of a tone so high that a period has few samples. Steady
    /// harmonics of the tone then cancel.
    pub(crate) block: usize,
    /// Energy of the tone in each block, all white channels together.
    energy: Vec<f64>,
    /// Mean energy in a block of noise that rings the mode.
    narrow: f64,
}

/// An amplitude that grows where it should decay.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Regrowth {
    /// Block of least energy before.
    pub(crate) least: usize,
    /// Block of largest energy after it.
    pub(crate) grown: usize,
    /// Ratio of the amplitudes.
    pub(crate) factor: f64,
}

impl Envelope {
    /// Demodulates at the strongest tone between the two frequencies, Hz.
    pub(crate) fn new(white: White<'_>, band_hz: (f64, f64)) -> Result<Self, Fault> {
        let rows = white.rows();
        let strongest = strongest_channel(white);
        let mut series: Vec<f64> =
            white.samples.iter().skip(strongest).step_by(white.channels).copied().collect();
        let too_short = Fault::TooShort { what: "record", have: rows, need: 64 };
        if rows < 64 {
            return Err(too_short);
        }
        // The loudest part comes first: what a power of two leaves out is the end of the decay.
        let span = 1 << rows.ilog2();
        series.truncate(span);
        let transform = transform::forward(span);
        let mut spectrum = transform.make_output_vec();
        if transform.process(&mut series, &mut spectrum).is_err() {
            return Err(too_short);
        }
        let resolution = 1.0 / (span as f64 * white.step);
        let range = spectrum.iter().enumerate().filter(|&(k, _)| {
            let f = k as f64 * resolution;
            f >= band_hz.0 && f <= band_hz.1
        });
        let (k, _) = range.max_by(|a, b| a.1.norm_sqr().total_cmp(&b.1.norm_sqr())).ok_or(too_short)?;
        let omega = std::f64::consts::TAU * resolution * k.max(1) as f64;
        let period = std::f64::consts::TAU / (omega * white.step);
        let block = (((BLOCK / period).ceil().max(1.0) * period).round() as usize).max(2);
        let turn = C64::from_polar(1.0, -omega * white.step);
        let mut sums = vec![C64::ZERO; white.channels];
        let mut energy = Vec::with_capacity(rows / block);
        for rows in white.samples.chunks_exact(block * white.channels) {
            sums.fill(C64::ZERO);
            let mut phasor = C64::ONE;
            for row in rows.chunks_exact(white.channels) {
                for (sum, &y) in sums.iter_mut().zip(row) {
                    *sum += phasor * y;
                }
                phasor *= turn;
            }
            energy.push(sums.iter().map(|z| z.norm_sqr()).sum());
        }
        Ok(Self { omega, block, energy, narrow: 0.0 })
    }

    /// First and last block of the forced plateau, whose energy stays above [`PLATEAU`] of the largest, but
    /// for noise. The energy E of a block of n samples has the standard deviation sqrt(2 n E).
    pub(super) fn plateau(&self) -> (usize, usize) {
        let top = self.top();
        let noise = NOISE * ((2.0 * self.block as f64 + 2.0 * self.narrow) * top).sqrt();
        let top = (PLATEAU * (top - noise) - noise).max(LEAST * top);
        let last = self.energy.iter().rposition(|&e| e >= top).unwrap_or(0);
        let first = self.energy[..last].iter().rposition(|&e| e < top).map_or(0, |j| j + 1);
        (first, last)
    }

    /// What the mode does, as far as the envelope tells, in noise that gives it the amplitude squared
    /// `power`; blocks are judged accordingly.
    pub(crate) fn ringing(&mut self, power: f64, step: f64) -> Ringing {
        self.narrow = 0.25 * power * (self.block as f64).powi(2);
        let (top, last) = (self.top(), self.plateau().1);
        let fallen = self.energy[last..].iter().position(|&e| e < (-2.0_f64).exp() * top);
        let blocks = fallen.unwrap_or(self.energy.len() - last).max(1);
        Ringing { power, s: C64::new(-1.0 / ((blocks * self.block) as f64 * step), self.omega) }
    }

    /// By how much noise that rings the mode may raise a block of the given energy.
    fn by_chance(&self, energy: f64) -> f64 {
        let most = CHANCE * self.narrow;
        2.0 * (most * energy).sqrt() + most
    }

    /// By how much noise may set the energies of two blocks apart, of which each has the deviation of
    /// [`Self::plateau`].
    fn noise_between(&self, a: f64, b: f64) -> f64 {
        SURELY * (2.0 * self.block as f64 * (a + b)).sqrt()
    }

    /// By how much beating with neighbouring modes, and noise that rings the mode, may raise a block.
    fn risen(&self, lowest: f64, highest: f64) -> f64 {
        0.2 * lowest + 0.02 * highest + self.by_chance(lowest)
    }

    fn top(&self) -> f64 {
        self.energy.iter().fold(0.0_f64, |a, &b| a.max(b))
    }

    /// First sample that is certainly after the end of forcing, for a first fit.
    pub(crate) fn safe_start(&self) -> usize {
        (self.plateau().1 + 2) * self.block
    }

    /// Whether the amplitude grows again after it has begun to fall: the block of least energy, one in which
    /// it has grown by then, and the factor of the amplitude. What beats with neighbouring modes can do stays
    /// below a fifth of the energy plus a fiftieth of the largest so far, or what noise can do. A second
    /// excitation may be the louder one: the largest so far counts, not the largest of all.
    pub(crate) fn regrowth(&self) -> Option<Regrowth> {
        let risen = self.energy.iter().position(|&e| e >= RISEN * self.top())?;
        let (mut highest, mut least, mut found): (f64, usize, Option<usize>) = (0.0, risen, None);
        for (j, &e) in self.energy.iter().enumerate().skip(risen) {
            let lowest = self.energy[least];
            let fall = ((1.0 - PLATEAU) * highest).max(self.noise_between(lowest, highest));
            let fallen = highest - lowest > fall;
            if found.is_none() && (e < lowest || !fallen) {
                // Until the amplitude has fallen, every block begins anew.
                least = j;
                highest = e.max(highest);
            } else if e > lowest + self.risen(lowest, highest).max(self.noise_between(e, lowest)) {
                // The block of largest energy says best what has grown.
                found = found.filter(|&k| self.energy[k] >= e).or(Some(j));
            }
        }
        let grown = found?;
        Some(Regrowth { least, grown, factor: (self.energy[grown] / self.energy[least]).sqrt() })
    }

    /// Whether the amplitude falls faster later on than just after the plateau: then the plateau was an
    /// overshoot, and the forcing goes on after it. A free decay falls as fast from its beginning. Only what
    /// is far above the noise is asked.
    pub(crate) fn falls_late(&self, channels: usize, step: f64) -> bool {
        let span = ((FALL / step) as usize / self.block).max(2);
        let first = self.plateau().1 + 1;
        let floor = FAR * (channels * self.block) as f64;
        let fall = |j: usize| {
            let (a, b) = (self.energy.get(j)?, self.energy.get(j + span)?);
            (*b > floor).then(|| (a / b).ln())
        };
        let Some(early) = fall(first) else { return false };
        (first + span..).map_while(fall).any(|late| early < SLOW * late)
    }

    /// First block that is loud, and the last one before the record sinks into noise of unit variance, if
    /// any.
    pub(crate) fn loud(&self, channels: usize) -> Option<(usize, usize)> {
        let (floor, top) = (LOUD * (channels * self.block) as f64, self.top());
        let first = self.energy.iter().position(|&e| e >= RISEN * top)?;
        let last = self.energy.iter().rposition(|&e| e >= floor)?;
        (first <= last).then_some((first, last))
    }

    /// The end of forcing: the change point of highest likelihood between a steady tone and the
    /// decay `free` (fitted from sample `fitted_from` on), plus the shortest lag at which noise could still
    /// hide the tone. None if the record holds too little steady forcing to say.
    pub(crate) fn decay_start(
        &self,
        white: White<'_>,
        free: &Solution,
        fitted_from: usize,
    ) -> Option<Change> {
        let (first, last) = self.plateau();
        let end = (last.saturating_sub(2)) * self.block;
        // The last blocks of the plateau may hold decay already: fit the tone well before its end.
        let decay = free.components.first().map_or(0.0, |c| -c.s.re).max(0.1);
        let end = end.saturating_sub((0.1 / (decay * white.step)) as usize);
        let begin = ((first + 3) * self.block).max(end.saturating_sub((FORCED / white.step) as usize));
        if end < begin + 8 * self.block {
            return None;
        }
        let forced = forced(white.slice(begin, end), self.omega, Kind::Tone, free)?;
        Some(change(white, (&forced, begin), (free, fitted_from), end))
    }
}

/// Longest stretch of forcing that is looked at, s.
pub(crate) const FORCED: f64 = 0.3;
/// Energy of a block over that of the noise above which a decay can be told from noise: amplitude ten times
/// the noise of the block.
const LOUD: f64 = 100.0;

/// A stretch of forcing: a steady tone near `omega` and the mains; and the modes of `free` that the
/// switching-on has excited, if they explain more than chance would. The tone is steady ([`Kind::Tone`]) or
/// may grow and fade ([`Kind::Mode`]).
pub(crate) fn forced(stretch: White<'_>, omega: f64, kind: Kind, free: &Solution) -> Option<Solution> {
    let mut tones = vec![Component::new(C64::new(0.0, omega), kind)];
    tones.extend(free.components.iter().filter(|c| matches!(c.kind, Kind::Mains(_))));
    let lasting = free.components.iter().filter(|c| c.kind == Kind::Tone);
    tones.extend(lasting.map(|c| Component::new(c.s, Kind::Known)));
    let steady = solve(stretch, &tones, SETTLING);
    let known: Vec<Component> = free.components.iter().filter(|c| c.kind == Kind::Mode).copied().collect();
    // Amplitudes of modes that do not sound take up half of this, on average.
    let chance = (4 * known.len() * stretch.channels) as f64;
    tones.splice(
        1..1,
        known.into_iter().map(|c| Component { kind: Kind::Known, ..Component::new(c.s, c.kind) }),
    );
    match (steady, solve(stretch, &tones, SETTLING)) {
        (Ok(steady), Ok(risen)) if steady.residual - risen.residual < chance => Some(steady),
        (steady, risen) => risen.or(steady).ok(),
    }
}

/// The end of forcing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Change {
    /// The first row without forcing, most likely.
    pub(crate) row: usize,
    /// Rows after it in which noise could still hide forcing.
    pub(crate) lag: usize,
}

impl Change {
    /// The first row that certainly belongs to the decay; `order` rows depend on what was before.
    pub(crate) fn start(&self, order: usize) -> usize {
        self.row + self.lag + order
    }
}

/// The change point of highest likelihood, from row `scan_from` on, between `forced` and `free`, each with
/// the first row of its fit, plus the shortest lag at which noise could still hide the difference.
pub(crate) fn change(
    white: White<'_>,
    (forced, begin): (&Solution, usize),
    (free, fitted_from): (&Solution, usize),
    scan_from: usize,
) -> Change {
    let region = white.slice(scan_from, fitted_from);
    let offset = scan_from as f64;
    let squares = |left: Vec<f64>| -> Vec<f64> {
        left.chunks_exact(white.channels).map(|row| row.iter().map(|v| v * v).sum()).collect()
    };
    let steady = squares(forced.residuals(region, offset - begin as f64));
    let decaying = squares(free.residuals(region, offset - fitted_from as f64));
    let (mut sum, mut best, mut change) = (0.0, 0.0, 0);
    for (n, (a, b)) in steady.iter().zip(&decaying).enumerate() {
        sum += a - b;
        if sum < best {
            (best, change) = (sum, n + 1);
        }
    }
    let strength = forced.strength();
    let split = (free.components[0].s - forced.components[0].s).norm();
    // The difference of the two models grows as |b| |s - i omega_f| t: its sum of squares reaches 1/16 here.
    let lag = ((0.375 * white.step / (strength * split * split)).cbrt() / white.step).ceil() as usize;
    Change { row: scan_from + change, lag }
}

/// Angular frequency of the strongest tone of a stretch between two frequencies (Hz), 1/s, to a small part of
/// its resolution.
pub(crate) fn strongest(stretch: White<'_>, band_hz: (f64, f64)) -> Option<f64> {
    let channel = strongest_channel(stretch);
    let length = (4 * stretch.rows().max(16)).next_power_of_two();
    let transform = transform::forward(length);
    let (mut series, mut spectrum) = (transform.make_input_vec(), transform.make_output_vec());
    let samples = stretch.samples.iter().skip(channel).step_by(stretch.channels);
    series.iter_mut().zip(samples).for_each(|(out, y)| *out = *y);
    transform.process(&mut series, &mut spectrum).ok()?;
    let resolution = 1.0 / (length as f64 * stretch.step);
    let inside = |k: usize| (band_hz.0..=band_hz.1).contains(&(k as f64 * resolution));
    let range = spectrum.iter().enumerate().filter(|&(k, _)| inside(k));
    let (k, _) = range.max_by(|a, b| a.1.norm_sqr().total_cmp(&b.1.norm_sqr()))?;
    Some(std::f64::consts::TAU * resolution * k as f64)
}

fn strongest_channel(white: White<'_>) -> usize {
    let mut energy = vec![0.0; white.channels];
    for row in white.samples.chunks_exact(white.channels) {
        for (sum, y) in energy.iter_mut().zip(row) {
            *sum += y * y;
        }
    }
    energy.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).map_or(0, |(m, _)| m)
}
