//! The error of a mean of few repeats: the scatter of the same quantity at all points, and what each fit
//! says of its noise.
//!
//! Repeats of one quantity at point k scatter with the variance w_k + b_k: w_k is the noise that the fits
//! state, b_k what comes on top (draughts, say). Two or three repeats hardly say how large b_k is; those of
//! all points do. The hierarchical model: ln b_k is normal about mu with deviation tau, both learnt from
//! all points (flat prior of mu and of the three tau tried), but for one point in a hundred, whose b_k is
//! larger by any factor; the sum of squares of n repeats is chi-squared with n - 1 degrees of freedom times
//! w_k + b_k. The mean of a point, b_k integrated out, then has heavier tails than a normal one. The
//! variance that is returned is that of the normal distribution with the same 95.45 % interval: "two
//! standard deviations" means what it says. With many repeats it is (w + b)/n; a single point of two
//! repeats has nearly the interval of Student's t with one degree of freedom.

use rijke_numerics::dot;

/// What the repeats of one quantity at one point say.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Group {
    /// Mean of the variances that the fits state.
    pub(crate) within: f64,
    /// Sum of squared deviations from the mean of the repeats.
    pub(crate) squares: f64,
    /// Number of repeats.
    pub(crate) count: usize,
}

impl Group {
    fn freedom(&self) -> f64 {
        self.count as f64 - 1.0
    }
}

/// Steps of ln b: the likelihood of 40 repeats is 0.23 wide.
const STEP: f64 = 0.2;
/// Least b, relative to the least noise: less cannot be told from none. With one point and two or three
/// repeats it decides how much they are believed when they happen to agree; at this value intervals of two
/// deviations cover 93 % or more, whatever the ratio of scatter and noise.
const LEAST: f64 = 0.01;
/// Largest b, relative to the largest variance seen.
const LARGEST: f64 = 1e5;
/// Deviations of ln b from point to point that are tried.
const SPREADS: [f64; 3] = [0.2, 0.6, 1.2];
/// Share of points at which something else happened, so that repeats scatter more there, by any factor.
const ODD: f64 = 0.01;
/// Relative error of a half-width, and the most steps in which it is reached: ten are usual.
const NEAR: f64 = 1e-13;
const MOST: usize = 200;
/// Probability of two standard deviations of a normal distribution.
const TWO_DEVIATIONS: f64 = 0.954_499_736;

/// The variance of each group's mean.
pub(crate) fn variances_of_means(groups: &[Group]) -> Vec<f64> {
    let stated = |g: &Group| g.within / g.count.max(1) as f64;
    let noise = || groups.iter().map(|g| g.within).filter(|w| *w > 0.0);
    let least = noise().fold(f64::INFINITY, f64::min);
    if !groups.iter().any(|g| g.count > 1) || !least.is_finite() {
        return groups.iter().map(stated).collect();
    }
    let seen = |g: &Group| if g.count > 1 { (g.squares / g.freedom()).max(g.within) } else { g.within };
    let largest = LARGEST * groups.iter().map(seen).fold(least, f64::max);
    let nodes = ((largest / (LEAST * least)).ln() / STEP).ceil() as usize + 1;
    let scatter: Vec<f64> = (0..nodes).map(|i| LEAST * least * (STEP * i as f64).exp()).collect();
    let likelihoods: Vec<Vec<f64>> = groups.iter().map(|g| likelihood(g, &scatter)).collect();
    let prior = prior(&likelihoods, nodes);
    let variance = |(group, likelihood): (&Group, &Vec<f64>)| {
        let weights = posterior(&prior, likelihood);
        let half = half_width(group, &scatter, &weights);
        0.25 * half * half
    };
    groups.iter().zip(&likelihoods).map(variance).collect()
}

/// Likelihood of each scatter, relative to the largest.
fn likelihood(group: &Group, scatter: &[f64]) -> Vec<f64> {
    if group.count < 2 {
        return vec![1.0; scatter.len()];
    }
    let log = |b: &f64| {
        let variance = group.within + b;
        -0.5 * (group.freedom() * variance.ln() + group.squares / variance)
    };
    let logs: Vec<f64> = scatter.iter().map(log).collect();
    let largest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    logs.iter().map(|l| (l - largest).exp()).collect()
}

/// One choice of mu and tau: its weight, given all groups, and the distribution of ln b that it implies.
struct Law {
    weight: f64,
    density: Vec<f64>,
}

/// The laws that all groups together leave.
fn prior(likelihoods: &[Vec<f64>], nodes: usize) -> Vec<Law> {
    let mut laws: Vec<(f64, Vec<f64>)> = Vec::with_capacity(SPREADS.len() * nodes);
    for spread in SPREADS {
        let bell: Vec<f64> = (0..nodes).map(|i| (-0.5 * (i as f64 * STEP / spread).powi(2)).exp()).collect();
        for middle in 0..nodes {
            let mut density: Vec<f64> = (0..nodes).map(|i| bell[i.abs_diff(middle)]).collect();
            let sum: f64 = density.iter().sum();
            let above = ODD / (nodes - middle) as f64;
            let odd = |i: usize| if i < middle { 0.0 } else { above };
            density.iter_mut().enumerate().for_each(|(i, d)| *d = (1.0 - ODD) * *d / sum + odd(i));
            let evidence = |l: &Vec<f64>| dot(l, &density).max(f64::MIN_POSITIVE).ln();
            laws.push((likelihoods.iter().map(evidence).sum(), density));
        }
    }
    let best = laws.iter().map(|l| l.0).fold(f64::NEG_INFINITY, f64::max);
    let weighed = laws.into_iter().map(|(log, density)| Law { weight: (log - best).exp(), density });
    weighed.filter(|law| law.weight > 1e-9).collect()
}

/// Probability of each scatter at a point.
fn posterior(laws: &[Law], likelihood: &[f64]) -> Vec<f64> {
    let mut weights = vec![0.0; likelihood.len()];
    for law in laws {
        let scale = law.weight / dot(likelihood, &law.density).max(f64::MIN_POSITIVE);
        for ((sum, l), d) in weights.iter_mut().zip(likelihood).zip(&law.density) {
            *sum += scale * l * d;
        }
    }
    let total: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|w| *w /= total);
    weights
}

/// Half the width of the interval about the mean of `group` that holds the truth with [`TWO_DEVIATIONS`].
fn half_width(group: &Group, scatter: &[f64], weights: &[f64]) -> f64 {
    let count = group.count.max(1) as f64;
    let outside = |half: f64| -> f64 {
        let tail = |(b, w): (&f64, &f64)| w * libm::erfc(half * (0.5 * count / (group.within + b)).sqrt());
        scatter.iter().zip(weights).filter(|(_, w)| **w > 1e-12).map(tail).sum()
    };
    let variance = |b: Option<&f64>| (group.within + b.copied().unwrap_or(0.0)) / count;
    // The logarithm of what is outside is nearly a line over the logarithm of the half-width.
    let over = |x: f64| (outside(x.exp()).max(f64::MIN_POSITIVE) / (1.0 - TWO_DEVIATIONS)).ln();
    let (low, high) = (0.5 * variance(None).ln(), 5_f64.ln() + 0.5 * variance(scatter.last()).ln());
    crossing(over, low, high).exp()
}

/// Where a falling function crosses zero between `low` and `high`, to rounding: false position that halves
/// the value of an end which stays (Illinois; Dowell & Jarratt, BIT 11 (1971) 168). Where it does not cross,
/// the end at which it is nearest.
fn crossing(f: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let (mut at_low, mut at_high) = (f(low), f(high));
    if at_low <= 0.0 || at_high >= 0.0 {
        return if at_low <= 0.0 { low } else { high };
    }
    let mut rising = None;
    for _ in 0..MOST {
        let x = (low * at_high - high * at_low) / (at_high - at_low);
        let at = f(x);
        if at.abs() < NEAR || high - low < NEAR {
            return x;
        }
        // An end that stays for the second time counts half.
        let share = if rising == Some(at > 0.0) { 0.5 } else { 1.0 };
        rising = Some(at > 0.0);
        if at > 0.0 {
            (low, at_low, at_high) = (x, at, share * at_high);
        } else {
            (high, at_high, at_low) = (x, at, share * at_low);
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{ChiSquared, Distribution, StandardNormal};
    use rijke_numerics::Streams;

    fn group(within: f64, squares: f64, count: usize) -> Group {
        Group { within, squares, count }
    }

    #[test]
    fn oracle_one_point_with_large_scatter_has_students_intervals() {
        // Half of Student's 95.45 % points with 1, 2, 4 and 39 degrees of freedom (tables).
        for (count, half) in [(2, 13.968), (3, 4.527), (5, 2.869), (40, 2.066)] {
            let freedom = count as f64 - 1.0;
            let found = variances_of_means(&[group(1e-9, freedom, count)])[0];
            let want = (0.5_f64 * half).powi(2) / count as f64;
            assert!(
                (found / want).sqrt() - 1.0 < 0.02 && (found / want).sqrt() > 0.95,
                "{count}: {found} {want}"
            );
        }
    }

    #[test]
    fn exact_crossings_of_known_places() {
        for place in [-0.7, 0.1, 2.9] {
            let found = crossing(|x| (place - x) * (1.0 + (x - 1.0).powi(2)), -1.0, 3.0);
            assert!((found - place).abs() < 1e-12, "{found} {place}");
        }
        assert_eq!([crossing(|x| -1.0 - x, -0.5, 3.0), crossing(|x| 9.0 - x, -0.5, 3.0)], [-0.5, 3.0]);
    }

    #[test]
    fn exact_points_without_repeats_have_what_their_fits_state() {
        assert_eq!(variances_of_means(&[group(2.0, 0.0, 1), group(3.0, 0.0, 1)]), [2.0, 3.0]);
        assert_eq!(variances_of_means(&[group(0.0, 0.0, 2)]), [0.0]);
    }

    /// Share of truths inside two stated deviations: `points` points of `count` repeats, scatter over noise
    /// `ratio` (as variances) that differs from point to point by a deviation `spread` of its logarithm.
    fn coverage(points: usize, count: usize, ratio: f64, spread: f64, seeds: u64) -> f64 {
        let freedom = count as f64 - 1.0;
        let (mut inside, mut all) = (0.0, 0.0);
        for seed in 0..seeds {
            let mut stream = Streams::new(seed).stream(&format!("pool {points} {count} {ratio} {spread}"));
            let mut groups = Vec::new();
            let mut errors = Vec::new();
            for k in 0..points {
                let within = 1.0 + (k % 3) as f64;
                let normal: f64 = StandardNormal.sample(&mut stream);
                let variance = within + ratio * (spread * normal).exp();
                let chi: f64 = ChiSquared::new(freedom).unwrap().sample(&mut stream);
                let error: f64 = StandardNormal.sample(&mut stream);
                groups.push(group(within, variance * chi, count));
                errors.push(error * (variance / count as f64).sqrt());
            }
            for (error, variance) in errors.iter().zip(variances_of_means(&groups)) {
                inside += f64::from(u8::from(error.abs() < 2.0 * variance.sqrt()));
                all += 1.0;
            }
        }
        inside / all
    }

    #[test]
    fn coverage_of_twenty_points_is_right_at_any_number_of_repeats() {
        for count in [2, 3, 5, 40] {
            for (ratio, spread) in [(0.0, 0.0), (1.0, 0.0), (100.0, 0.0), (100.0, 1.0), (1e4, 0.3)] {
                let share = coverage(20, count, ratio, spread, 60);
                // 1200 numbers: the error of a share is 0.6 %.
                assert!((0.92..0.98).contains(&share), "{count} repeats, scatter {ratio}, {spread}: {share}");
            }
        }
    }

    #[test]
    fn coverage_of_a_single_point_never_falls_short() {
        for count in [2, 3, 5, 40] {
            for ratio in [0.0, 1.0, 10.0, 100.0, 1e4] {
                let share = coverage(1, count, ratio, 0.0, 1000);
                // Twice the error of a share of 1000 below 93 %. Where noise is all there is, few repeats
                // cannot tell.
                assert!(share > 0.916, "{count} repeats, scatter {ratio}: {share}");
            }
        }
    }
}
