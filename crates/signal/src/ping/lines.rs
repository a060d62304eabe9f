//! Steady tones beside the mode in the silence before the forcing: a fan, a machine, hum.
//!
//! Noise that rings a mode is as wide as the mode, a steady tone as narrow as the silence allows. The tone of
//! least squares at the frequency of most power takes a steady tone away, and of the other a part: noise of a
//! mode with the decay rate a, over a time T, keeps about aT/6 of its power.

use super::search::floor;
use crate::dsp::climb::climb;
use crate::dsp::kernels::{Powers, add_scaled, dot};
use crate::dsp::noise::tone;
use rijke_numerics::C64;
use std::f64::consts::TAU;

/// Most tones that are looked for: with more of them beside a mode no decay can be fitted.
const MOST: usize = 3;
/// Mean power, over that of the noise beside it, from which a tone stands out, and from which it is no noise
/// that rings a mode of aT > 0.1 if nothing is left of it.
const STANDS_OUT: f64 = 8.0;
const STRONG: f64 = 100.0;
/// Frequencies, in resolutions of the silence, beside a tone: what is left there, and the noise.
const LEFT: [f64; 3] = [-1.0, 0.0, 1.0];
const BESIDE: [f64; 8] = [-6.5, -5.5, -4.5, -3.5, 3.5, 4.5, 5.5, 6.5];
/// Standard deviations by which what is left may exceed the noise: chance reaches it in one silence of 1e5.
const CALM: f64 = 6.0;
/// Samples that tell.
const FEWEST: usize = 64;

/// Tones that were found.
pub(super) struct Lines {
    /// Their frequencies, Hz.
    pub(super) hertz: Vec<f64>,
    /// The silence without them.
    pub(super) rest: Vec<Vec<f64>>,
    /// Whether they are steady: strong, and nothing is left of them.
    pub(super) steady: bool,
}

/// The tones of a silence within `apart_hz` of a frequency.
pub(super) fn lines(silence: &[Vec<f64>], rate_hz: f64, about_hz: f64, apart_hz: f64) -> Lines {
    let rows = silence.first().map_or(0, Vec::len);
    let mut found = Lines { hertz: Vec::new(), rest: silence.to_vec(), steady: true };
    let bin = rate_hz / rows.max(1) as f64;
    // A tone of less than ten periods is not told from what wanders.
    let (low, high) = ((about_hz - apart_hz).max(10.0 * bin), (about_hz + apart_hz).min(0.45 * rate_hz));
    if rows < FEWEST || low >= high {
        return found;
    }
    let count = silence.len() as f64;
    for _ in 0..MOST {
        let Some(hz) = loudest(&found.rest, rate_hz, (low, high)) else { break };
        let wave = powers(hz, rate_hz, rows);
        let amplitudes = tone(&found.rest, &wave);
        let mut rest = found.rest.clone();
        for (y, a) in rest.iter_mut().zip(&amplitudes) {
            add_scaled(y, -a.re, &wave.re);
            add_scaled(y, a.im, &wave.im);
        }
        let near = |offsets: &[f64]| {
            let mut sums = vec![0.0; rest.len()];
            for offset in offsets {
                let power = of_each(&rest, hz + offset * bin, rate_hz);
                sums.iter_mut().zip(power).for_each(|(sum, p)| *sum += p / offsets.len() as f64);
            }
            sums
        };
        let level: Vec<f64> = near(&BESIDE).into_iter().map(|p| p.max(f64::MIN_POSITIVE)).collect();
        // Of noise alone the energy is chi-squared with two degrees of freedom per channel.
        let energy: f64 =
            amplitudes.iter().zip(&level).map(|(a, level)| 0.5 * a.norm_sqr() * rows as f64 / level).sum();
        let power = 0.5 * energy / count;
        if energy < floor(silence.len()) || power < STANDS_OUT {
            break;
        }
        let left = near(&LEFT).iter().zip(&level).map(|(p, level)| p / level).sum::<f64>() / count;
        let chance = CALM * (LEFT.len() as f64 * count).sqrt().recip();
        found.steady &= power > STRONG && left < 1.0 + chance;
        found.hertz.push(hz);
        found.rest = rest;
    }
    found
}

fn powers(hz: f64, rate_hz: f64, rows: usize) -> Powers {
    Powers::new(C64::from_polar(1.0, TAU * hz / rate_hz), rows)
}

/// Power at a frequency in each channel; its mean is the variance for white noise.
fn of_each(series: &[Vec<f64>], hz: f64, rate_hz: f64) -> Vec<f64> {
    let rows = series.first().map_or(0, Vec::len);
    let wave = powers(hz, rate_hz, rows);
    let of = |y: &Vec<f64>| C64::new(dot(y, &wave.re), -dot(y, &wave.im)).norm_sqr() / rows as f64;
    series.iter().map(of).collect()
}

/// The frequency of most power between two others, Hz.
fn loudest(series: &[Vec<f64>], rate_hz: f64, (low, high): (f64, f64)) -> Option<f64> {
    let power = |hz: f64| of_each(series, hz, rate_hz).iter().sum::<f64>();
    let rows = series.first().map_or(0, Vec::len);
    let step = 0.5 * rate_hz / rows.max(1) as f64;
    let count = ((high - low) / step).ceil() as usize;
    let grid = (0..=count).map(|k| (low + step * k as f64).min(high));
    let best = grid.map(|hz| (hz, power(hz))).max_by(|a, b| a.1.total_cmp(&b.1))?;
    // The power of a line is a parabola to a small part of a resolution.
    Some(climb(power, best, step, 12).0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution, StandardNormal};
    use rijke_numerics::Streams;

    /// Three channels of white noise with a tone of this amplitude at 172 Hz, and with noise that rings a
    /// mode there with a rate (1/s).
    fn silence(seconds: f64, amplitude: f64, rings: Option<(f64, f64)>, seed: u64) -> Vec<Vec<f64>> {
        let mut stream = Streams::new(seed).stream("lines");
        let mut normal = || -> f64 { StandardNormal.sample(&mut stream) };
        let rows = (seconds * 1e4) as usize;
        let (size, keep) = rings.map_or((0.0, 0.0), |(size, a)| (size, (-a * 1e-4_f64).exp()));
        let mut state = C64::new(normal(), normal()) * size;
        let mut out = vec![Vec::new(); 3];
        for n in 0..rows {
            state = state * keep + C64::new(normal(), normal()) * (size * (1.0 - keep * keep).sqrt());
            let turn = C64::from_polar(1.0, TAU * 172.0 * n as f64 * 1e-4);
            for (y, share) in out.iter_mut().zip([1.0, 0.7, 1.2]) {
                y.push(share * ((state * turn).re + amplitude * turn.im) + normal());
            }
        }
        out
    }

    #[test]
    fn exact_a_steady_tone_is_told_from_noise_that_rings_a_mode() {
        for seconds in [0.2, 1.0, 2.0] {
            for seed in 0..8 {
                let found = lines(&silence(seconds, 1.0, None, seed), 1e4, 170.0, 12.0);
                assert!(found.steady && found.hertz.len() == 1, "{seconds}: {:?}", found.hertz);
                assert!((found.hertz[0] - 172.0).abs() < 0.3 / seconds, "{:?}", found.hertz);
                assert!(lines(&silence(seconds, 0.0, None, seed), 1e4, 170.0, 12.0).hertz.is_empty());
                // What rings on through a third of the silence is a steady tone there.
                for a in [4.0, 12.0, 40.0].into_iter().filter(|a| a * seconds > 3.0) {
                    let rung = lines(&silence(seconds, 0.0, Some((1.0, a)), seed), 1e4, 170.0, 12.0);
                    assert!(!rung.steady || rung.hertz.is_empty(), "{seconds} s, {a} 1/s: {:?}", rung.hertz);
                }
            }
        }
    }
}
