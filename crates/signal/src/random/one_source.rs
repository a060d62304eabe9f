//! Pressures of one source at three or more channels, each of which has noise of its own, from cross spectra.

use super::spectra::Spectra;
use rijke_numerics::C64;

/// Sweeps over the channels, of which each brings a channel to where the others put it.
const SWEEPS: usize = 60;

/// Frequencies on either side with which the power of noise is averaged.
const BESIDE: usize = 4;

/// Pressures by frequency and channel, and the standard deviation of each part of their logarithms, which are
/// independent.
pub(super) struct OneSource {
    pub(super) pressures: Vec<Vec<C64>>,
    pub(super) relative_sd: Vec<Vec<f64>>,
}

impl OneSource {
    /// Of the first `channels` channels, three or more: the p with the least sum of |S_ij - conj(p_i) p_j|^2
    /// over the pairs i != j of cross spectra S (Harman & Jones, Psychometrika 31 (1966) 351, a factor
    /// analysis with one factor). What a channel hears alone stands on the diagonal only, and does not bias p
    /// as it does a cross spectrum over a spectrum.
    pub(super) fn of(found: &Spectra, channels: usize) -> Self {
        let pressures: Vec<Vec<C64>> = found.cross.iter().map(|sums| factor(sums, channels)).collect();
        let near = |k: usize| k.saturating_sub(BESIDE)..(k + BESIDE + 1).min(pressures.len());
        let mean = |k: usize, of: &dyn Fn(usize) -> f64| near(k).map(of).sum::<f64>() / near(k).len() as f64;
        // Of what a channel hears alone, in parts of what it hears of the source.
        let alone = |c: usize| {
            let pressures = &pressures;
            move |k: usize| (found.cross[k][c][c].re / power(&pressures[k][c]) - 1.0).max(0.0)
        };
        // Of the cross spectra of a channel: what no noise of its own explains, such as a rig that changes
        // within the width of a segment's frequencies, and the least where the noise is too small to be seen.
        let between = |c: usize| {
            let pressures = &pressures;
            move |k: usize| {
                let p = &pressures[k];
                let left = |j: usize| {
                    let said = p[c].conj() * p[j];
                    (found.cross[k][c][j] - said).norm_sqr() / power(&said)
                };
                (0..channels).filter(|j| *j != c).map(left).sum::<f64>() / (channels - 1) as f64
            }
        };
        // A cross spectrum has the errors of two channels.
        let sd = |k: usize, c: usize| {
            let noise = mean(k, &alone(c)) / (2.0 * found.averages);
            noise.max(0.25 * mean(k, &between(c))).max(1e-12).sqrt()
        };
        let relative_sd = (0..pressures.len()).map(|k| (0..channels).map(|c| sd(k, c)).collect()).collect();
        Self { pressures, relative_sd }
    }
}

/// The square of the modulus, as a divisor.
fn power(z: &C64) -> f64 {
    z.norm_sqr().max(f64::MIN_POSITIVE)
}

/// The p of one frequency, from the sums of conj(X_i) X_j.
fn factor(sums: &[Vec<C64>], channels: usize) -> Vec<C64> {
    let loudest = (0..channels).max_by(|a, b| sums[*a][*a].re.total_cmp(&sums[*b][*b].re)).unwrap_or(0);
    let size = sums[loudest][loudest].re.sqrt().max(f64::MIN_POSITIVE);
    // Row i is conj(p_i) p.
    let mut p: Vec<C64> = sums[loudest][..channels].iter().map(|s| s / size).collect();
    for _ in 0..SWEEPS {
        for k in 0..channels {
            let others = || (0..channels).filter(|j| *j != k);
            let power: f64 = others().map(|j| p[j].norm_sqr()).sum();
            let heard: C64 = others().map(|j| p[j] * sums[j][k]).sum();
            p[k] = heard / power.max(f64::MIN_POSITIVE);
        }
    }
    p
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution, StandardNormal};
    use rijke_numerics::Streams;

    /// Spectra of a source that four channels hear as `truth`, with noise of their own, by 300 averages.
    fn heard(truth: [C64; 4], noise: [f64; 4], name: &str) -> Spectra {
        let mut stream = Streams::new(8).stream(name);
        let mut normal = || -> C64 {
            let parts: [f64; 2] = [0, 1].map(|_| StandardNormal.sample(&mut stream));
            C64::new(parts[0], parts[1])
        };
        let mut one = || {
            let mut sums = vec![vec![C64::ZERO; 4]; 4];
            for _ in 0..300 {
                let source = normal();
                let all: Vec<C64> = (0..4).map(|c| truth[c] * source + noise[c] * normal()).collect();
                for (i, row) in sums.iter_mut().enumerate() {
                    row.iter_mut().zip(&all).for_each(|(sum, x)| *sum += all[i].conj() * x);
                }
            }
            sums
        };
        let cross = (0..200).map(|_| one()).collect();
        Spectra { frequency_hz: (0..200).map(f64::from).collect(), averages: 300.0, cross }
    }

    /// The first channel near a node, with as much noise as signal: a cross spectrum over its spectrum is
    /// half of the ratio, and the root of the ratio of the spectra 0.7 of it.
    #[test]
    fn coverage_ratios_over_a_channel_near_a_node() {
        let truth = [C64::new(0.1, 0.0), C64::new(0.8, 0.3), C64::new(-0.5, 0.4), C64::new(0.2, -0.9)];
        let found = OneSource::of(&heard(truth, [0.1, 0.1, 0.05, 0.2], "node"), 4);
        let (mut square, mut sum) = ([0.0; 4], [C64::ZERO; 4]);
        for (p, sd) in found.pressures.iter().zip(&found.relative_sd) {
            for c in 1..4 {
                let ratio = (p[c] / p[0]) / (truth[c] / truth[0]);
                sum[c] += ratio;
                square[c] += ratio.ln().norm_sqr() / (2.0 * (sd[c].powi(2) + sd[0].powi(2)));
            }
        }
        for c in 1..4 {
            let (mean, pull) = (sum[c] / 200.0, (square[c] / 200.0_f64).sqrt());
            assert!((mean - 1.0).norm() < 0.02, "channel {c}: {mean}");
            assert!((0.85..1.15).contains(&pull), "channel {c}: {pull}");
        }
    }
}
