//! Pressures of one source at several channels, each of which has noise of its own, from cross spectra.

use super::spectra::Spectra;
use rijke_numerics::C64;
use std::iter;

/// Sweeps over the channels, of which each brings a channel to where the others put it.
const SWEEPS: usize = 60;

/// Frequencies on either side with which the power of noise is averaged.
const BESIDE: usize = 4;

/// Pressures by frequency and channel, and the standard deviation of each part of their logarithms, which are
/// independent.
pub(super) struct OneSource {
    pub(super) pressures: Vec<Vec<C64>>,
    pub(super) relative_sd: Vec<Vec<f64>>,
    /// The share of the power of a channel that is the source's.
    share: Vec<Vec<f64>>,
}

impl OneSource {
    /// Of the first `channels` channels: of three or more by what all have in common, of two by the root of
    /// the ratio of their spectra.
    pub(super) fn of(found: &Spectra, channels: usize) -> Self {
        if channels > 2 { Self::of_several(found, channels) } else { Self::of_two(found, channels) }
    }

    /// The median share of each channel at the frequencies `used`.
    pub(super) fn shares(&self, used: &[usize]) -> Vec<f64> {
        let median = |c: usize| {
            let mut all: Vec<f64> = used.iter().map(|k| self.share[*k][c]).collect();
            all.sort_by(f64::total_cmp);
            all.get(all.len() / 2).copied().unwrap_or(1.0)
        };
        (0..self.share.first().map_or(0, Vec::len)).map(median).collect()
    }

    /// Of one or two channels, whose noise is taken for alike, so that nothing is told of their shares.
    fn of_two(found: &Spectra, channels: usize) -> Self {
        let all: Vec<_> = (1..channels).map(|c| found.transfer(0, c)).collect();
        let over = |k: usize| all.iter().map(move |transfer| transfer[k]);
        let each = || 0..found.frequency_hz.len();
        Self {
            pressures: each()
                .map(|k| iter::once(C64::ONE).chain(over(k).map(|h| h.even())).collect())
                .collect(),
            relative_sd: each()
                .map(|k| iter::once(0.0).chain(over(k).map(|h| h.relative_sd)).collect())
                .collect(),
            share: each().map(|_| vec![1.0; channels]).collect(),
        }
    }

    /// The p with the least sum of |S_ij - conj(p_i) p_j|^2
    /// over the pairs i != j of cross spectra S (Harman & Jones, Psychometrika 31 (1966) 351, a factor
    /// analysis with one factor). What a channel hears alone stands on the diagonal only, and does not bias p
    /// as it does a cross spectrum over a spectrum.
    fn of_several(found: &Spectra, channels: usize) -> Self {
        let pressures: Vec<Vec<C64>> = found.cross.iter().map(|sums| factor(sums, channels)).collect();
        let near = |k: usize| k.saturating_sub(BESIDE)..(k + BESIDE + 1).min(pressures.len());
        let mean = |k: usize, of: &dyn Fn(usize) -> f64| near(k).map(of).sum::<f64>() / near(k).len() as f64;
        // The power of what a channel hears alone.
        let alone = |c: usize| {
            let pressures = &pressures;
            move |k: usize| found.cross[k][c][c].re - pressures[k][c].norm_sqr()
        };
        // What no noise of its own explains, such as a rig that changes within the width of a segment's
        // frequencies, and the least where the noise is too small to be seen: what the cross spectra of a
        // channel differ by, with the errors of two channels each. The lower median, because a channel near a
        // node spoils those of all others.
        let between = |c: usize| {
            let pressures = &pressures;
            move |k: usize| {
                let p = &pressures[k];
                let left = |j: usize| (found.cross[k][c][j] - p[c].conj() * p[j]).norm_sqr() / power(&p[j]);
                let mut all: Vec<f64> = (0..channels).filter(|j| *j != c).map(left).collect();
                all.sort_by(f64::total_cmp);
                all[(channels - 2) / 2]
            }
        };
        // Of n (n - 1) real numbers the fit takes 2 n - 1.
        let (pairs, taken) = ((channels * (channels - 1)) as f64, (2 * channels - 1) as f64);
        let freedom = pairs / (pairs - taken);
        let sd = |k: usize, c: usize| {
            let noise = mean(k, &alone(c)) / (2.0 * found.averages);
            let variance = noise.max(0.25 * freedom * mean(k, &between(c))) / power(&pressures[k][c]);
            // Rounding is not less.
            variance.max(1e-12).sqrt()
        };
        let share =
            |k: usize, c: usize| pressures[k][c].norm_sqr() / found.cross[k][c][c].re.max(f64::MIN_POSITIVE);
        let all = |of: &dyn Fn(usize, usize) -> f64| -> Vec<Vec<f64>> {
            (0..pressures.len()).map(|k| (0..channels).map(|c| of(k, c)).collect()).collect()
        };
        let (relative_sd, share) = (all(&sd), all(&share));
        Self { pressures, relative_sd, share }
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

    /// Spectra of a source that four channels hear as `truth` says at each frequency, with noise of their
    /// own, by 300 averages.
    fn heard(truth: impl Fn(usize) -> [C64; 4], noise: [f64; 4], name: &str) -> Spectra {
        let mut stream = Streams::new(8).stream(name);
        let mut normal = || -> C64 {
            let parts: [f64; 2] = [0, 1].map(|_| StandardNormal.sample(&mut stream));
            C64::new(parts[0], parts[1])
        };
        let mut one = |k: usize| {
            let mut sums = vec![vec![C64::ZERO; 4]; 4];
            for _ in 0..300 {
                let source = normal();
                let all: Vec<C64> = (0..4).map(|c| truth(k)[c] * source + noise[c] * normal()).collect();
                for (i, row) in sums.iter_mut().enumerate() {
                    row.iter_mut().zip(&all).for_each(|(sum, x)| *sum += all[i].conj() * x);
                }
            }
            sums
        };
        let cross = (0..200).map(&mut one).collect();
        Spectra { frequency_hz: (0..200).map(f64::from).collect(), averages: 300.0, cross }
    }

    /// Beyond a node, which moves past the first channel, its pressure over another is wrong by as much as is
    /// stated, however small it is.
    #[test]
    fn coverage_of_a_channel_past_which_a_node_moves() {
        let others = [C64::new(0.8, 0.3), C64::new(-0.5, 0.4), C64::new(0.2, -0.9)];
        let truth = |k: usize| [C64::new(0.01 * (k as f64 - 99.5), 0.0), others[0], others[1], others[2]];
        let found = OneSource::of(&heard(truth, [0.1, 0.1, 0.05, 0.2], "moves"), 4);
        let pull = |k: usize| {
            let (p, sd) = (&found.pressures[k], &found.relative_sd[k]);
            let (ratio, true_ratio) = (p[0] / p[1], truth(k)[0] / truth(k)[1]);
            (ratio - true_ratio).norm_sqr() / (2.0 * ratio.norm_sqr() * (sd[0].powi(2) + sd[1].powi(2)))
        };
        let rms = |range: std::ops::Range<usize>| {
            let count = range.len() as f64;
            (range.map(pull).sum::<f64>() / count).sqrt()
        };
        assert!((0.85..1.15).contains(&rms(0..200)), "{}", rms(0..200));
        assert!((0.7..1.3).contains(&rms(90..110)), "{}", rms(90..110));
    }

    /// The first channel near a node, with as much noise as signal: a cross spectrum over its spectrum is
    /// half of the ratio, and the root of the ratio of the spectra 0.7 of it.
    #[test]
    fn coverage_ratios_over_a_channel_near_a_node() {
        let truth = [C64::new(0.1, 0.0), C64::new(0.8, 0.3), C64::new(-0.5, 0.4), C64::new(0.2, -0.9)];
        let found = OneSource::of(&heard(|_| truth, [0.1, 0.1, 0.05, 0.2], "node"), 4);
        // The last two are ratios of channels away from the node.
        for [a, b] in [[1, 0], [2, 0], [3, 0], [2, 1], [3, 1]] {
            let ratio = |p: &[C64]| (p[a] / p[b]) / (truth[a] / truth[b]);
            let pull = |(p, sd): (&Vec<C64>, &Vec<f64>)| {
                ratio(p).ln().norm_sqr() / (2.0 * (sd[a].powi(2) + sd[b].powi(2)))
            };
            let mean = found.pressures.iter().map(|p| ratio(p)).sum::<C64>() / 200.0;
            let squares: f64 = found.pressures.iter().zip(&found.relative_sd).map(pull).sum();
            assert!((mean - 1.0).norm() < 0.02, "{a} over {b}: {mean}");
            assert!(
                (0.8..1.15).contains(&(squares / 200.0).sqrt()),
                "{a} over {b}: {}",
                (squares / 200.0).sqrt()
            );
        }
    }
}
