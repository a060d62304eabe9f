//! Where an impulse is in a record, to about a sample.

use crate::click::ClickOptions;
use crate::kernels::LANES;
use crate::{Fault, Trace};
use pulp::Arch;

/// Half length of the smoothing kernel of the high-pass filter, s: hum at 50 Hz falls to 3e-4, and what the filter
/// smears from later reflections into the window is below their mean over 3 ms.
const SMOOTHING: f64 = 1.5e-3;
/// Largest shift between a channel and the strongest one that the first alignment corrects, s.
const REACH: f64 = 0.35e-3;

/// Impulses found to about a sample.
#[derive(Clone, Debug)]
pub(crate) struct Located {
    /// Arrival times after the end of the quiet part, s.
    pub(crate) times: Vec<f64>,
    /// Gains relative to the strongest channel.
    pub(crate) gains: Vec<f64>,
    pub(crate) pivot: usize,
}

impl Located {
    pub(crate) fn find(trace: &Trace<'_>, options: &ClickOptions) -> Result<Self, Fault> {
        let half = ((SMOOTHING * trace.rate_hz).ceil() as usize).max(2);
        if trace.len() < 8 * half {
            return Err(Fault::TooShort { what: "record", have: trace.len(), need: 8 * half });
        }
        let quiet = trace.quiet.min(trace.len());
        let begin = 2 * (half - 1);
        let spread = (0.3e-3 * trace.rate_hz).ceil() as usize;
        let channels: Vec<Filtered> =
            trace.channels.chunks(LANES).flat_map(|group| high_pass(group, half, spread)).collect();
        let silence = quiet.saturating_sub(begin + spread);
        let mut found = Vec::new();
        for (m, channel) in channels.iter().enumerate() {
            let burst = first_burst(&channel.energy, silence, spread);
            found.push(burst.ok_or_else(|| no_impulse(m, &channel.z, silence))?);
        }
        // A reflection that overlaps the direct impulse hides its shape: such a channel cannot lead the others.
        let pivot = (0..found.len())
            .filter(|&m| !options.overlaps(m))
            .max_by(|&a, &b| found[a].1.total_cmp(&found[b].1))
            .unwrap_or(0);
        let margin = ((options.window.0 + options.window.1 + REACH) * trace.rate_hz) as usize;
        let mut located = Self { times: Vec::new(), gains: Vec::new(), pivot };
        let length = channels[0].z.len();
        if found.iter().any(|&(n, _)| n < margin || n + margin >= length) {
            return Err(Fault::TooShort {
                what: "record around the impulse",
                have: length,
                need: 2 * margin,
            });
        }
        let centre = centroid(&channels[pivot].z, found[pivot].0, spread);
        for (m, &(n, _)) in found.iter().enumerate() {
            let (lag, gain) = align(&channels[pivot].z, centre, &channels[m].z, n, trace.rate_hz);
            let sample = (lag + begin) as f64 - quiet as f64;
            located.times.push(sample / trace.rate_hz);
            located.gains.push(gain);
        }
        Ok(located)
    }
}

fn no_impulse(channel: usize, z: &[f64], silence: usize) -> Fault {
    let silence = silence.min(z.len());
    let rms = |y: &[f64]| (y.iter().map(|v| v * v).sum::<f64>() / y.len().max(1) as f64).sqrt();
    let peak = z[silence..].iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    let ratio = peak / rms(&z[..silence.max(1).min(z.len())]);
    Fault::NoImpulse { channel, ratio }
}

/// A channel through the high-pass filter, and the energy of each of its stretches of a given length.
struct Filtered {
    z: Vec<f64>,
    energy: Vec<f64>,
}

/// Twice over, y less its mean under a triangle of half length `half`: a linear-phase high-pass filter of finite
/// length, 2 `half` on each side, so that what comes later in the record reaches back by no more than that. Up to
/// [`LANES`] channels side by side; energies over `spread` samples.
fn high_pass(group: &[Vec<f64>], half: usize, spread: usize) -> Vec<Filtered> {
    let mut rows = vec![[0.0; LANES]; group[0].len()];
    for (lane, y) in group.iter().enumerate() {
        rows.iter_mut().zip(y).for_each(|(row, y)| row[lane] = *y);
    }
    let mut smooth = rows.clone();
    // The two means together are centred `half` - 1 samples after their first sample.
    let (shift, mut length) = (half - 1, rows.len());
    Arch::new().dispatch(|| {
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
    });
    let energies = &smooth[..length + 1 - spread];
    let lane = |i: usize| Filtered {
        z: rows[..length].iter().map(|row| row[i]).collect(),
        energy: energies.iter().map(|mean| mean[i] * spread as f64).collect(),
    };
    (0..group.len()).map(lane).collect()
}

/// Means of `length` successive rows, in place of the first of them; the last `length` - 1 rows are left over.
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

/// Sample of the first burst that holds a good part of the largest energy of any burst, and its energy. None if no
/// burst stands out of the noise before `silence`.
fn first_burst(energy: &[f64], silence: usize, spread: usize) -> Option<(usize, f64)> {
    let noise = energy[..silence.min(energy.len())].iter().fold(0.0_f64, |a, &b| a.max(b));
    let later = energy.get(silence..)?;
    let top = later.iter().fold(0.0_f64, |a, &b| a.max(b));
    if top < 4.0 * noise {
        return None;
    }
    let mut n = later.iter().position(|&e| e > 0.4 * top)?;
    while n + 1 < later.len()
        && later[n + 1..later.len().min(n + 1 + spread / 3)].iter().any(|&e| e > later[n])
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

/// Sample of `other` that matches sample `centre` of `pivot`, by the largest correlation of either sign near `near`,
/// and the gain at that lag. Of two similar maxima the earlier is taken: a reflection comes later.
fn align(pivot: &[f64], centre: usize, other: &[f64], near: usize, rate_hz: f64) -> (usize, f64) {
    let half = (0.4e-3 * rate_hz) as usize;
    let reach = (REACH * rate_hz) as usize;
    let reference = &pivot[centre - half..centre + half];
    let power: f64 = reference.iter().map(|v| v * v).sum();
    let correlations: Vec<(usize, f64)> = (near - reach..near + reach)
        .filter(|&n| n >= half && n + half <= other.len())
        .map(|n| {
            let product: f64 = reference.iter().zip(&other[n - half..n + half]).map(|(a, b)| a * b).sum();
            (n, product / power)
        })
        .collect();
    let top = correlations.iter().fold(0.0_f64, |a, c| a.max(c.1.abs()));
    let peaks = correlations.windows(3).filter(|w| {
        w[1].1.abs() >= w[0].1.abs() && w[1].1.abs() >= w[2].1.abs() && w[1].1.abs() > 0.85 * top
    });
    peaks.map(|w| w[1]).next().unwrap_or((near, 1.0))
}
