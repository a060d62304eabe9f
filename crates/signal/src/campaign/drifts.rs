//! The drift of the frequency during the decays, at all points of a campaign together.
//!
//! A drift too small to be seen at a point moves its frequency by several stated errors. So it is never taken
//! as none: at each point it is free, with a prior that all points teach (empirical Bayes). The relative
//! drift of a point is normal about a mean mu with a deviation tau; mu has a flat prior, tau one that is
//! flat in its logarithm, and both are integrated out. A single point says no more than its own decays do;
//! many points without a drift say that there is little.

use super::fitted::PingOfRecord;
use crate::ping::Drift;
use rijke_numerics::words::with_sd;
use rijke_rig::Ping;

/// Values of tau that are tried: from this share of the least error to this multiple of the largest drift or
/// error.
const LEAST: f64 = 0.2;
const LARGEST: f64 = 10.0;
/// Their number.
const VALUES: usize = 40;
/// Room temperature, K.
const ROOM: f64 = 293.15;

/// Weight of a law, over the largest, below which it does not count.
const NEGLIGIBLE: f64 = 1e-9;

/// A relative drift, 1/s, and its standard deviation; the part of it that is an error of the mean drift,
/// which all points have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Relative {
    pub(super) rate: f64,
    pub(super) sd: f64,
    pub(super) common: f64,
}

/// What each point's drift is, given all of them. Those of unknown error stay as they are.
pub(super) fn shared(own: &[Relative]) -> Vec<Relative> {
    let known = || own.iter().filter(|d| d.is_known());
    let least = known().map(|d| d.sd).fold(f64::INFINITY, f64::min);
    if known().count() < 2 {
        return own.to_vec();
    }
    let largest = known().map(|d| d.sd.max(d.rate.abs())).fold(0.0, f64::max);
    let ratio = (LARGEST * largest / (LEAST * least)).powf(1.0 / (VALUES - 1) as f64);
    let scatters: Vec<f64> = (0..VALUES).map(|k| LEAST * least * ratio.powi(k as i32)).collect();
    given_all(own, &scatters, &[f64::INFINITY]).0
}

/// What each number is, given all of them: normal about a mean with one of the deviations `scatters`, the
/// mean normal about zero with one of `sizes`, or of any value; all of them are as likely before. Those of
/// unknown error stay as they are. And the logarithm of the likelihood of all numbers, over that of their
/// being what was measured.
pub(super) fn given_all(own: &[Relative], scatters: &[f64], sizes: &[f64]) -> (Vec<Relative>, f64) {
    let known: Vec<Relative> = own.iter().copied().filter(Relative::is_known).collect();
    let of = |tau: &f64| sizes.iter().map(|size| Law::of(&known, *tau, *size)).collect::<Vec<_>>();
    let laws: Vec<Law> = scatters.iter().flat_map(of).collect();
    let best = laws.iter().map(|l| l.log).fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = laws.iter().map(|l| (l.log - best).exp()).collect();
    let total: f64 = weights.iter().sum();
    let of = |d: &Relative| {
        if !d.is_known() {
            return *d;
        }
        let (mut mean, mut square, mut common) = (0.0, 0.0, 0.0);
        for (law, weight) in laws.iter().zip(&weights).filter(|(_, weight)| **weight > NEGLIGIBLE) {
            let weight = weight / total;
            let (value, [own, of_the_mean]) = law.given(d);
            mean += weight * value;
            square += weight * (own + of_the_mean + value * value);
            common += weight * of_the_mean;
        }
        Relative { rate: mean, sd: (square - mean * mean).max(0.0).sqrt(), common: common.sqrt() }
    };
    let of_errors: f64 = known.iter().map(|d| d.sd.ln()).sum();
    (own.iter().map(of).collect(), best + (total / laws.len() as f64).ln() + of_errors)
}

impl Relative {
    fn is_known(&self) -> bool {
        self.sd.is_finite() && self.sd > 0.0
    }
}

/// One pair of deviations, with the logarithm of its likelihood, and the mean and its variance that go with
/// it.
struct Law {
    square: f64,
    log: f64,
    mean: f64,
    variance: f64,
}

impl Law {
    fn of(known: &[Relative], tau: f64, size: f64) -> Self {
        let (square, prior) = (tau * tau, (size * size).recip());
        let weight = |d: &Relative| (square + d.sd * d.sd).recip();
        let total: f64 = known.iter().map(weight).sum::<f64>() + prior;
        let mean = known.iter().map(|d| weight(d) * d.rate).sum::<f64>() / total;
        let term = |d: &Relative| weight(d).ln() - weight(d) * (d.rate - mean).powi(2);
        let of_mean = if prior > 0.0 { prior.ln() - prior * mean * mean } else { 0.0 };
        let log = 0.5 * (known.iter().map(term).sum::<f64>() + of_mean - total.ln());
        Self { square, log, mean, variance: total.recip() }
    }

    /// Mean and variance of a number that was measured so: its own part, and that of the mean.
    fn given(&self, d: &Relative) -> (f64, [f64; 2]) {
        let own = d.sd * d.sd;
        let share = own / (self.square + own);
        let value = d.rate + share * (self.mean - d.rate);
        (value, [share * self.square, share * share * self.variance])
    }
}

/// A drift, and the standard deviation of the part of its error that all points have in common, rad/s^2.
pub(super) type Learnt = (Drift, f64);

/// For each point the drift that its pings have in common, by themselves, and with what all points teach.
pub(super) fn drifts_of(points: &[Vec<&PingOfRecord>]) -> Vec<(Drift, Learnt)> {
    let of = |pings: &Vec<&PingOfRecord>| {
        let drifts: Vec<Drift> = pings.iter().map(|p| p.drift).collect();
        (Drift::common(&drifts), pings.last().map_or(0.0, |p| p.ping.s.im))
    };
    let common: Vec<(Drift, f64)> = points.iter().map(of).collect();
    common.iter().map(|c| c.0).zip(learnt(&common)).collect()
}

/// The drift of each point's pings, from what they have in common, `common`, and the angular frequencies.
fn learnt(common: &[(Drift, f64)]) -> Vec<Learnt> {
    let relative = |(drift, omega): &(Drift, f64)| Relative {
        rate: drift.rate / omega,
        sd: drift.sd / omega,
        common: 0.0,
    };
    let found = shared(&common.iter().map(relative).collect::<Vec<_>>());
    let back = |((drift, omega), found): (&(Drift, f64), Relative)| {
        (Drift { rate: found.rate * omega, sd: found.sd * omega, ..*drift }, found.common * omega)
    };
    common.iter().zip(found).map(back).collect()
}

/// The pings of one point with their frequencies at the end of the forcing, by the drift that they have in
/// common, whose error is still to be added: single pings may hold a drift that none of them shows beyond its
/// noise.
pub(super) fn without_drift(pings: Vec<(usize, Ping, Drift)>, common: &Drift) -> Vec<(usize, Ping)> {
    let clear = |(repeat, mut ping, own): (usize, Ping, Drift)| {
        if common.sd.is_finite() {
            if own.is_significant() {
                own.put_back(&mut ping);
            }
            ping.s.im -= common.rate * own.moment;
        }
        (repeat, ping)
    };
    pings.into_iter().map(clear).collect()
}

/// Relative drift of the speed of sound, 1/s, beyond which a second mode is named beside a gas that changes:
/// air that warms by 1.2 K/s.
const FAST: f64 = 2e-3;

pub(super) fn drift_in_words(point: &str, drift: &Drift, pings: &[(usize, Ping)]) -> String {
    let frequency = pings.iter().map(|(_, p)| p.s.im).sum::<f64>() / pings.len().max(1) as f64;
    let (relative, sd) = (drift.rate / frequency, drift.sd / frequency);
    // The speed of sound grows as the square root of the temperature.
    let said = format!(
        "{point}: the frequency drifts by ({}) % per second during the decays, as it does where the temperature of the gas, in kelvins, {} by \
         {:.2} % per second; frequencies are those at the end of the forcing",
        with_sd(100.0 * relative, 100.0 * sd),
        if relative > 0.0 { "rises" } else { "falls" },
        200.0 * relative.abs()
    );
    if relative.abs() < FAST {
        return said;
    }
    let kelvin = 2.0 * relative.abs() * ROOM;
    said + &format!(
        ". That is fast: {kelvin:.1} K/s at room temperature. If the gas does not change so, a second mode of nearly the same frequency and shape is in the \
         decay, and the growth rate is wrong: excite one of them alone"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution, StandardNormal};
    use rijke_numerics::Streams;

    /// Frequencies of `points` points: rms of error over stated deviation, share inside two, and the stated
    /// deviation over that of a fit which knows that nothing drifts. In units of that deviation a drift of 1
    /// moves the frequency by 2, and is known to 1, as in a long decay. Points drift by `mean`, with a
    /// scatter. Last the same rms of the mean over the points, whose errors have a part in common.
    fn study(points: usize, mean: f64, scatter: f64) -> [f64; 4] {
        let (mut squares, mut inside, mut stated, mut of_mean, seeds) = (0.0, 0.0, 0.0, 0.0, 200_u64);
        for seed in 0..seeds {
            let mut stream = Streams::new(seed).stream(&format!("drifts {points} {mean} {scatter}"));
            let mut normal = || -> f64 { StandardNormal.sample(&mut stream) };
            let truth: Vec<f64> = (0..points).map(|_| mean + scatter * normal()).collect();
            let own: Vec<Relative> =
                truth.iter().map(|t| Relative { rate: t + normal(), sd: 1.0, common: 0.0 }).collect();
            let (mut error_of_all, mut own_of_all, mut common_of_all) = (0.0, 0.0, 0.0);
            for (found, truth) in shared(&own).iter().zip(&truth) {
                let error = normal() - 2.0 * (found.rate - truth);
                let sd = (1.0 + 4.0 * found.sd * found.sd).sqrt();
                squares += (error / sd).powi(2);
                inside += f64::from(u8::from(error.abs() < 2.0 * sd));
                stated += sd;
                error_of_all += error;
                common_of_all += 2.0 * found.common;
                own_of_all += sd * sd - 4.0 * found.common.powi(2);
            }
            of_mean += error_of_all.powi(2) / (own_of_all + common_of_all.powi(2)) / seeds as f64;
        }
        let n = points as f64 * seeds as f64;
        [(squares / n).sqrt(), inside / n, stated / n, of_mean.sqrt()]
    }

    #[test]
    fn coverage_of_drifts_that_no_point_shows() {
        for points in [1, 2, 5, 20] {
            for (mean, scatter) in [(0.0, 0.0), (0.3, 0.0), (1.0, 0.0), (3.0, 0.0), (0.0, 1.0), (2.0, 3.0)] {
                let [rms, inside, stated, of_mean] = study(points, mean, scatter);
                println!(
                    "| {points} | {mean} | {scatter} | {rms:.2} | {inside:.3} | {stated:.2} | {of_mean:.2} |"
                );
                // What they have in common does not average out.
                assert!(of_mean < 1.15, "{points} {mean} {scatter}: {of_mean}");
                assert!(rms < 1.15 && inside > 0.92, "{points} {mean} {scatter}: {rms} {inside}");
                assert!(scatter > 0.0 || points < 20 || stated < 1.5, "{points} {mean}: {stated}");
            }
        }
    }
}
