//! Where the forcing ends and the free decay begins, found from the record itself.

use crate::Fault;
use crate::ringdown::{Component, Kind, SETTLING, Solution, White, solve};
use crate::transform;
use rijke_numerics::C64;

/// Energy of a block, relative to the largest, above which it belongs to the forced plateau. Free decay leaves it
/// after 0.08 decay times, early enough to keep most of the record for the first fit.
const PLATEAU: f64 = 0.85;
/// Energy of a block, relative to the largest, from which the forcing counts as risen: a second excitation may be four
/// times as loud as the first.
const RISEN: f64 = 0.05;

/// What the envelope of the strongest tone shows.
#[derive(Clone, Debug)]
pub(crate) struct Envelope {
    /// Angular frequency of the strongest tone, 1/s.
    pub(crate) omega: f64,
    /// Samples per block: one period, so that steady harmonics of the tone cancel.
    pub(crate) block: usize,
    /// Energy of the tone in each block, all white channels together.
    energy: Vec<f64>,
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
        let block = ((std::f64::consts::TAU / (omega * white.step)).round() as usize).max(2);
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
        Ok(Self { omega, block, energy })
    }

    /// First and last block of the forced plateau, whose energy stays above [`PLATEAU`] of the largest.
    fn plateau(&self) -> (usize, usize) {
        let top = PLATEAU * self.top();
        let last = self.energy.iter().rposition(|&e| e >= top).unwrap_or(0);
        let first = self.energy[..last].iter().rposition(|&e| e < top).map_or(0, |j| j + 1);
        (first, last)
    }

    fn top(&self) -> f64 {
        self.energy.iter().fold(0.0_f64, |a, &b| a.max(b))
    }

    /// First sample that is certainly after the end of forcing, for a first fit.
    pub(crate) fn safe_start(&self) -> usize {
        (self.plateau().1 + 2) * self.block
    }

    /// Whether the amplitude grows again after it has begun to fall: the block of least energy, one in which it has
    /// grown by then, and the factor of the amplitude. What beats with neighbouring modes and noise can do stays
    /// below a fifth of the energy plus a fiftieth of the largest so far. A second excitation may be the louder one: the
    /// largest so far counts, not the largest of all.
    pub(crate) fn regrowth(&self) -> Option<Regrowth> {
        let risen = self.energy.iter().position(|&e| e >= RISEN * self.top())?;
        let (mut highest, mut least, mut found): (f64, usize, Option<usize>) = (0.0, risen, None);
        for (j, &e) in self.energy.iter().enumerate().skip(risen) {
            let lowest = self.energy[least];
            if found.is_none() && (e < lowest || lowest >= PLATEAU * highest) {
                // Until the amplitude has fallen, every block begins anew.
                least = j;
                highest = e.max(highest);
            } else if e > 1.2 * lowest + 0.02 * highest {
                // The block of largest energy says best what has grown.
                found = found.filter(|&k| self.energy[k] >= e).or(Some(j));
            }
        }
        let grown = found?;
        Some(Regrowth { least, grown, factor: (self.energy[grown] / self.energy[least]).sqrt() })
    }

    /// First sample of the free decay: the change point of highest likelihood between a steady tone and the decay
    /// `free` (fitted from sample `fitted_from` on), plus the shortest lag at which noise could still hide the tone.
    /// None if the record holds too little steady forcing to say.
    pub(crate) fn decay_start(
        &self,
        white: White<'_>,
        free: &Solution,
        fitted_from: usize,
        order: usize,
    ) -> Option<usize> {
        let (first, last) = self.plateau();
        let end = (last.saturating_sub(2)) * self.block;
        // The last blocks of the plateau may hold decay already: fit the tone well before its end.
        let decay = free.components.first().map_or(0.0, |c| -c.s.re).max(0.1);
        let end = end.saturating_sub((0.1 / (decay * white.step)) as usize);
        let begin = ((first + 3) * self.block).max(end.saturating_sub((0.3 / white.step) as usize));
        if end < begin + 8 * self.block {
            return None;
        }
        let mut tones = vec![Component { s: C64::new(0.0, self.omega), kind: Kind::Tone }];
        tones.extend(free.components.iter().filter(|c| matches!(c.kind, Kind::Mains(_))));
        let slice = |a: usize, b: usize| White {
            samples: &white.samples[a * white.channels..b * white.channels],
            ..white
        };
        let forced = solve(slice(begin, end), &tones, SETTLING).ok()?;
        let (scan_from, scan_to) = (end, fitted_from.min(white.rows()));
        let region = slice(scan_from, scan_to);
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
        let strength: f64 = forced.amplitudes[0].iter().map(|a| a.norm_sqr()).sum();
        let split = (free.components[0].s - forced.components[0].s).norm();
        // The difference of the two models grows as |b| |s - i omega_f| t: its sum of squares reaches 1/16 here.
        let lag = ((0.375 * white.step / (strength * split * split)).cbrt() / white.step).ceil() as usize;
        Some(scan_from + change + order + lag)
    }
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
