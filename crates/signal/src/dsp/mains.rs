//! The frequency of the mains, from a long stretch of noise that hums.

use super::climb::climb;
use super::kernels::{Powers, dot};
use rijke_numerics::C64;

/// Shortest stretch, s, whose hum tells its frequency, and by what share that lies from the nominal one at
/// most.
const TELLS: f64 = 0.3;
const WITHIN: f64 = 0.005;
/// Periods over which hum is averaged before its frequency is sought: the other harmonics are nothing then.
const PERIODS: f64 = 5.0;
/// Twice the logarithm of the likelihood that another frequency must have more than the nominal one: chance
/// gives one unknown this once in 20 000.
const LIKELIER: f64 = 18.0;
/// Standard deviations of what noise explains beyond which there is hum: the best of a few hundred
/// frequencies reaches four.
const HUMS: f64 = 8.0;

/// The frequency of the mains, Hz, that explains most of a long stretch, of harmonics up to the `highest`
/// but for those that are `left`; the nominal one where the stretch does not tell.
pub(super) fn mains_of(noise: &[Vec<f64>], rate_hz: f64, nominal_hz: f64, highest: u32, left: &[u32]) -> f64 {
    let block = (PERIODS * rate_hz / nominal_hz).round().max(1.0) as usize;
    let length = noise.first().map_or(0, Vec::len);
    let blocks = length / block;
    if (length as f64) < TELLS * rate_hz || blocks < 3 {
        return nominal_hz;
    }
    // Means of each channel over blocks, turned back at the nominal frequency of each harmonic.
    let mut means: Vec<(f64, Vec<C64>)> = Vec::new();
    for harmonic in (1..=highest).filter(|h| !left.contains(h)) {
        let turn = C64::from_polar(1.0, std::f64::consts::TAU * f64::from(harmonic) * nominal_hz / rate_hz);
        let wave = Powers::new(turn, blocks * block);
        for y in noise {
            let scale = dot(y, y).sqrt().max(f64::MIN_POSITIVE).recip();
            let of = |k: usize| {
                let rows = k * block..(k + 1) * block;
                let (re, im) =
                    (dot(&y[rows.clone()], &wave.re[rows.clone()]), dot(&y[rows.clone()], &wave.im[rows]));
                C64::new(re, -im) * scale
            };
            means.push((f64::from(harmonic), (0..blocks).map(of).collect()));
        }
    }
    // What a frequency this much higher explains: an energy over the variance of the samples.
    let explained = |higher_hz: f64| -> f64 {
        let of = |(harmonic, z): &(f64, Vec<C64>)| {
            let turn = -std::f64::consts::TAU * harmonic * higher_hz * block as f64 / rate_hz;
            let sum: C64 = z.iter().enumerate().map(|(k, z)| z * C64::from_polar(1.0, turn * k as f64)).sum();
            2.0 * sum.norm_sqr()
        };
        means.iter().map(of).sum()
    };
    let reach = WITHIN * nominal_hz;
    let step = 0.25 * rate_hz / (length as f64 * f64::from(highest.max(1)));
    let count = (reach / step).ceil() as i32;
    let grid = (-count..=count).map(|k| f64::from(k) * step).map(|hz| (hz, explained(hz)));
    let Some(best) = grid.max_by(|a, b| a.1.total_cmp(&b.1)) else { return nominal_hz };
    let (best, most) = climb(explained, best, step, 10);
    // Of noise alone every amplitude explains a chi-squared with two degrees of freedom.
    let freedom = 2.0 * means.len() as f64;
    let hums = most > freedom + HUMS * (2.0 * freedom).sqrt();
    if hums && most > explained(0.0) + LIKELIER { nominal_hz + best } else { nominal_hz }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution, StandardNormal};
    use rijke_numerics::Streams;
    use std::f64::consts::TAU;

    #[test]
    fn exact_the_frequency_is_learnt_from_a_long_stretch_that_hums() {
        let silence = |seconds: f64, hz: f64, size: f64| -> Vec<Vec<f64>> {
            let mut stream = Streams::new(7).stream("mains");
            let mut of = |m: usize| -> Vec<f64> {
                let hum = |n: usize, h: f64| (TAU * hz * h * n as f64 * 1e-4 + h * m as f64).cos();
                let value = |n: usize, noise: f64| size * (hum(n, 1.0) + hum(n, 3.0) + hum(n, 4.0)) + noise;
                (0..(seconds * 1e4) as usize).map(|n| value(n, StandardNormal.sample(&mut stream))).collect()
            };
            (0..3).map(&mut of).collect()
        };
        for hz in [49.8, 49.97, 50.0, 50.03, 50.2] {
            for seconds in [0.7, 1.0, 2.0] {
                let found = mains_of(&silence(seconds, hz, 3.0), 1e4, 50.0, 8, &[]);
                assert!((found - hz).abs() < 3e-3 / seconds, "{seconds} s at {hz} Hz: {found}");
            }
            // Nothing is learnt from a short one, or from one that does not hum.
            assert_eq!(mains_of(&silence(0.2, hz, 3.0), 1e4, 50.0, 8, &[]), 50.0);
            assert_eq!(mains_of(&silence(1.0, hz, 0.0), 1e4, 50.0, 8, &[]), 50.0);
        }
    }
}
