//! Where an impulse is in a record, to a few microseconds: on means over as many samples as its band allows.

use super::options::ClickOptions;
use super::segment::decimation;
use crate::dsp::kernels::{LANES, dot, run};
use crate::{Fault, Trace};
use pulp::NullaryFnOnce;

/// Window of the fit for which the lengths that follow are meant, s: for longer ones they grow in proportion.
const WINDOW: f64 = 0.8e-3;
/// Half length of the smoothing kernel of the high-pass filter, s: hum at 50 Hz falls to 3e-4, and what the
/// filter smears from later reflections into the window is below their mean over 3 ms.
const SMOOTHING: f64 = 1.5e-3;
/// Largest shift between a channel and the strongest one that the first alignment corrects, s.
const REACH: f64 = 0.35e-3;

/// Channels nearest the end, from which the pace of sound there is read.
const NEAREST: usize = 3;

/// Impulses found.
#[derive(Clone, Debug)]
pub(crate) struct Located {
    /// Arrival times after the end of the quiet part, s.
    pub(crate) times: Vec<f64>,
    /// Gains relative to the strongest channel.
    pub(crate) gains: Vec<f64>,
    pub(crate) pivot: usize,
}

impl Located {
    /// How fast sound travels near the end of the path, as a factor of the lags that `options` state for the
    /// reflection: the direct impulse has crossed the same gas between the channels nearest the end.
    pub(crate) fn pace(&self, options: &ClickOptions) -> f64 {
        let Some(reflection) = &options.reflection else { return 1.0 };
        let mut near: Vec<(f64, f64)> =
            reflection.lags.iter().copied().zip(self.times.iter().copied()).collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        near.truncate(NEAREST);
        // The reflection goes there and back.
        match (near.first(), near.last()) {
            (Some(a), Some(b)) if b.0 > a.0 => {
                let (low, high) = (1.0 - 2.0 * reflection.pace_sd, 1.0 + 2.0 * reflection.pace_sd);
                (2.0 * (a.1 - b.1) / (b.0 - a.0)).clamp(low.max(0.5), high)
            }
            _ => 1.0,
        }
    }
}

/// The first burst of every channel.
pub(crate) struct Bursts {
    channels: Vec<Filtered>,
    /// Its sample and energy.
    found: Vec<(usize, f64)>,
    /// Time of the first filtered sample after the end of the quiet part, s.
    first: f64,
    rate_hz: f64,
    spread: usize,
    scale: f64,
}

impl Bursts {
    pub(crate) fn find(trace: &Trace<'_>, options: &ClickOptions) -> Result<Self, Fault> {
        let factor = decimation(trace.rate_hz, options.band_hz.1);
        let rate_hz = trace.rate_hz / factor as f64;
        let scale = (options.window.0.max(options.window.1) / WINDOW).max(1.0);
        let half = ((scale * SMOOTHING * rate_hz).ceil() as usize).max(2);
        if trace.len() < 8 * half * factor {
            return Err(Fault::TooShort { what: "record", have: trace.len(), need: 8 * half * factor });
        }
        let quiet = trace.quiet.min(trace.len());
        let begin = 2 * (half - 1);
        let spread = ((scale * 0.3e-3 * rate_hz).ceil() as usize).max(2);
        let channels: Vec<Filtered> =
            trace.channels.chunks(LANES).flat_map(|group| high_pass(group, factor, half, spread)).collect();
        let silence = (quiet / factor).saturating_sub(begin + spread);
        let mut found = Vec::new();
        for (m, channel) in channels.iter().enumerate() {
            let burst = first_burst(&channel.energy, silence, spread);
            found.push(burst.ok_or_else(|| no_impulse(m, &channel.z, silence))?);
        }
        let margin = ((options.window.0 + options.window.1 + scale * REACH) * rate_hz) as usize;
        let length = channels[0].z.len();
        if let Some(channel) = found.iter().position(|&(n, _)| n < margin || n + margin >= length) {
            let seconds = |samples: usize| samples as f64 / rate_hz;
            let before = seconds(found[channel].0 + begin);
            let after = trace.len() as f64 / trace.rate_hz - before;
            return Err(Fault::ImpulseAtEdge {
                channel: channel.into(),
                before,
                after,
                need: seconds(margin + begin),
            });
        }
        // The mean over `factor` samples belongs to their middle.
        let first = (begin * factor) as f64 + 0.5 * (factor - 1) as f64 - quiet as f64;
        Ok(Self { channels, found, first: first / trace.rate_hz, rate_hz, spread, scale })
    }

    /// Where a channel whose impulse is overlapped by its reflection lies by more than `far` (s) from where
    /// sound in known gas arrives, or upside down: the impulses with such channels where sound arrives. None
    /// if there is no such channel. Impulse and reflection together look like another impulse, upside down
    /// and later.
    pub(crate) fn expected(&self, located: &Located, options: &ClickOptions, far: f64) -> Option<Located> {
        let reflection = options.reflection.as_ref().filter(|r| r.pace_sd == 0.0)?;
        let (pivot, mut other) = (located.pivot, located.clone());
        let mut changed = false;
        for m in (0..located.times.len()).filter(|m| options.overlaps(*m) && *m != pivot) {
            // The reflection goes there and back.
            let time = located.times[pivot] + 0.5 * (reflection.lags[pivot] - reflection.lags[m]);
            if located.gains[m] < 0.0 || (located.times[m] - time).abs() > far {
                (other.times[m], other.gains[m], changed) = (time, 1.0, true);
            }
        }
        changed.then_some(other)
    }

    /// Brings the channels in phase.
    pub(crate) fn locate(&self, options: &ClickOptions) -> Located {
        let Self { channels, found, .. } = self;
        // A reflection that overlaps the direct impulse hides its shape: such a channel cannot lead the
        // others.
        let pivot = (0..found.len())
            .filter(|&m| !options.overlaps(m))
            .max_by(|&a, &b| found[a].1.total_cmp(&found[b].1))
            .unwrap_or(0);
        let mut located = Located { times: Vec::new(), gains: Vec::new(), pivot };
        let centre = centroid(&channels[pivot].z, found[pivot].0, self.spread);
        for (channel, &(n, _)) in channels.iter().zip(found) {
            let (place, gain) = align(&channels[pivot].z, centre, &channel.z, n, self.scale * self.rate_hz);
            located.times.push(self.first + place / self.rate_hz);
            located.gains.push(gain);
        }
        located
    }
}

fn no_impulse(channel: usize, z: &[f64], silence: usize) -> Fault {
    let silence = silence.min(z.len());
    let rms = |y: &[f64]| (y.iter().map(|v| v * v).sum::<f64>() / y.len().max(1) as f64).sqrt();
    let peak = z[silence..].iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    let ratio = peak / rms(&z[..silence.max(1).min(z.len())]);
    Fault::NoImpulse { channel: channel.into(), ratio }
}

/// A channel through the high-pass filter, and the energy of each of its stretches of a given length.
struct Filtered {
    z: Vec<f64>,
    energy: Vec<f64>,
}

/// Twice over, y less its mean under a triangle of half length `half`: a linear-phase high-pass filter of
/// finite length, 2 `half` on each side, so that what comes later in the record reaches back by no more than
/// that; y are means over `factor` samples. Up to [`LANES`] channels side by side; energies over `spread`
/// samples.
fn high_pass(group: &[Vec<f64>], factor: usize, half: usize, spread: usize) -> Vec<Filtered> {
    let mut rows = vec![[0.0; LANES]; group[0].len() / factor];
    for (lane, y) in group.iter().enumerate() {
        let means = y.chunks_exact(factor).map(|y| y.iter().sum::<f64>() / factor as f64);
        rows.iter_mut().zip(means).for_each(|(row, y)| row[lane] = y);
    }
    let mut smooth = rows.clone();
    // The two means together are centred `half` - 1 samples after their first sample.
    let length = rows.len() - 4 * (half - 1);
    run(HighPass { rows: &mut rows, smooth: &mut smooth, half, spread });
    let energies = &smooth[..length + 1 - spread];
    let lane = |i: usize| Filtered {
        z: rows[..length].iter().map(|row| row[i]).collect(),
        energy: energies.iter().map(|mean| mean[i] * spread as f64).collect(),
    };
    (0..group.len()).map(lane).collect()
}

struct HighPass<'a> {
    rows: &'a mut [[f64; LANES]],
    smooth: &'a mut [[f64; LANES]],
    half: usize,
    spread: usize,
}

impl NullaryFnOnce for HighPass<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { rows, smooth, half, spread } = self;
        let (shift, mut length) = (half - 1, rows.len());
        for _ in 0..2 {
            smooth[..length].copy_from_slice(&rows[..length]);
            running_mean(&mut smooth[..length], half);
            running_mean(&mut smooth[..length - shift], half);
            length -= 2 * shift;
            for n in 0..length {
                let row = rows[n + shift];
                rows[n] = std::array::from_fn(|i| row[i] - smooth[n][i]);
            }
        }
        for (square, row) in smooth.iter_mut().zip(&rows[..length]) {
            *square = row.map(|z| z * z);
        }
        running_mean(&mut smooth[..length], spread);
    }
}

/// Means of `length` successive rows, in place of the first of them; the last `length` - 1 rows are left
/// over.
#[inline(always)]
fn running_mean(rows: &mut [[f64; LANES]], length: usize) {
    let (mut sum, scale) = ([0.0; LANES], 1.0 / length as f64);
    for row in &rows[..length - 1] {
        (0..LANES).for_each(|i| sum[i] += row[i]);
    }
    for n in 0..rows.len() + 1 - length {
        let (first, last) = (rows[n], rows[n + length - 1]);
        for i in 0..LANES {
            sum[i] += last[i];
            rows[n][i] = scale * sum[i];
            sum[i] -= first[i];
        }
    }
}

/// Sample of the first burst that holds a good part of the largest energy of any burst, and its energy. None
/// if no burst stands out of the noise before `silence`.
fn first_burst(energy: &[f64], silence: usize, spread: usize) -> Option<(usize, f64)> {
    let noise = energy[..silence.min(energy.len())].iter().fold(0.0_f64, |a, &b| a.max(b));
    let later = energy.get(silence..)?;
    let top = later.iter().fold(0.0_f64, |a, &b| a.max(b));
    if top < 4.0 * noise {
        return None;
    }
    let mut n = later.iter().position(|&e| e > 0.4 * top)?;
    while n + 1 < later.len()
        && later[n + 1..later.len().min(n + 1 + (spread / 3).max(1))].iter().any(|&e| e > later[n])
    {
        n += 1;
    }
    Some((silence + n + spread / 2, later[n]))
}

/// Centre of energy near sample `n`.
fn centroid(z: &[f64], n: usize, spread: usize) -> usize {
    let (mut mass, mut moment) = (0.0, 0.0);
    for i in n.saturating_sub(spread)..(n + spread).min(z.len()) {
        mass += z[i] * z[i];
        moment += i as f64 * z[i] * z[i];
    }
    (moment / mass).round() as usize
}

/// Place in `other`, in samples, that matches sample `centre` of `pivot`, by the largest correlation of
/// either sign near `near`, and the gain there; between samples by a parabola. Of two similar maxima the
/// earlier is taken: a reflection comes later.
fn align(pivot: &[f64], centre: usize, other: &[f64], near: usize, rate_hz: f64) -> (f64, f64) {
    let half = (0.4e-3 * rate_hz) as usize;
    let reach = (REACH * rate_hz).ceil() as usize;
    let reference = &pivot[centre.saturating_sub(half)..(centre + half).min(pivot.len())];
    let power = dot(reference, reference);
    let first = near.saturating_sub(reach).max(half);
    let last = (near + reach).min((other.len() + half + 1).saturating_sub(reference.len()));
    let correlations: Vec<f64> =
        (first..last).map(|n| dot(reference, &other[n - half..n - half + reference.len()]) / power).collect();
    let vertex = |(k, w): (usize, &[f64])| {
        let (a, b, c) = (w[0], w[1], w[2]);
        let peaked = b.abs() > a.abs() && b.abs() >= c.abs();
        let offset = 0.5 * (a - c) / (a - 2.0 * b + c);
        peaked.then(|| ((first + k + 1) as f64 + offset, b - 0.25 * (a - c) * offset))
    };
    let peaks: Vec<(f64, f64)> = correlations.windows(3).enumerate().filter_map(vertex).collect();
    let top = peaks.iter().fold(0.0_f64, |a, p| a.max(p.1.abs()));
    peaks.into_iter().find(|p| p.1.abs() > 0.85 * top).unwrap_or((near as f64, 1.0))
}
