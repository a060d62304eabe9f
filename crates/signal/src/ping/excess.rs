//! Whether the damping of a ring-down depends on its amplitude, as it does where sound separates at holes and
//! open ends.
//!
//! A loss that grows with the amplitude, dA/dt = -c A (1 + x A/A(0)/(1 + ...)), leaves the envelope
//! e^{-ct} / (1 + x (1 - e^{-ct})): c is the damping at small amplitude, c (1 + x) that at the start. To
//! first order the logarithm of the amplitude gets the part x e^{-ct}, and one Gauss-Newton step in x alone
//! tells it, as in [`super::chirp`]: what is left of e^{-ct} after 1 and t are projected out is q = e^{-ct} -
//! a t - b. The growth rate that a fit without x finds is that at small amplitude and a x. An endless record
//! has a = -4/9 c: an excess of one standard deviation moves the growth rate by 2.8.

use super::slope::{Curve, Several, seen};
use crate::ringdown::Solution;
use rijke_rig::Ping;

/// By how much the damping exceeds that at small amplitude.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Excess {
    /// At the end of the forcing, as a share of the damping at small amplitude.
    pub share: f64,
    /// Its standard deviation.
    pub sd: f64,
    /// By how much an excess of 1 moves the growth rate of a fit that has none, 1/s.
    pub moved: f64,
}

/// Standard deviations beyond which an excess is taken as real: noise feigns it in one ping of 16 000.
const SIGNIFICANT: f64 = 4.0;

/// Fewest decay times of a fit that tell of an excess.
const LEAST: f64 = 3.0;

impl Excess {
    /// The excess that a fit has found, or, if it was not looked for, that its residuals `left` show.
    pub(crate) fn of(found: &Solution, left: &[f64], step: f64) -> Self {
        match (found.components[0].excess, found.curve_covariance(3)) {
            (Some(share), Some([own, mixed])) => {
                Self { share, sd: (found.variance() * own).sqrt(), moved: -mixed / own }.or_none()
            }
            _ => Self::left_by(found, left, step),
        }
    }

    /// The excess of a fit that has none, as its residuals show it.
    pub(crate) fn left_by(found: &Solution, left: &[f64], step: f64) -> Self {
        let amplitudes = &found.amplitudes[0];
        let rows = left.len() / amplitudes.len().max(1);
        if !Self::is_told(found.components[0].s.re, rows, step) {
            return Self::unknown();
        }
        let (s, wave) = (found.components[0].s, found.wave(rows, step));
        let Curve { values, slope, spread } = Curve::of(-s.re, -s.re, rows, step);
        let information = 0.5 * found.strength() * spread;
        let score = seen(left, amplitudes, &wave, |n| values[n]).re;
        let sd = (found.variance() / information).sqrt();
        Self { share: score / information, sd, moved: slope }.or_none()
    }

    /// Whether a fit of so many rows is long enough to tell an excess from a loudspeaker that comes to rest.
    pub(crate) fn is_told(growth_rate: f64, rows: usize, step: f64) -> bool {
        -growth_rate * rows as f64 * step > LEAST
    }

    /// Weights of the rows of a fit in its excess: times xi/b, where the amplitude is b e^{st} + xi e^{i
    /// omega t}.
    pub(crate) fn weights(decay: f64, rows: usize, step: f64) -> Vec<f64> {
        let Curve { values, spread, .. } = Curve::of(decay, decay, rows, step);
        let (mut fallen, fall) = (spread.recip(), (-decay * step).exp());
        let weight = |q: f64| {
            let now = q * fallen;
            fallen *= fall;
            now
        };
        values.into_iter().map(weight).collect()
    }

    /// The same for another variance of the noise than that of the fit.
    pub(crate) fn with_variance(self, found: &Solution, variance: f64) -> Self {
        Self { sd: self.sd * (variance / found.variance()).sqrt(), ..self }
    }

    /// The same at a time before the window, when the amplitude was larger by the given factor.
    pub(crate) fn counted_from(self, larger: f64) -> Self {
        Self { share: self.share * larger, sd: self.sd * larger, moved: self.moved / larger }
    }

    fn unknown() -> Self {
        Self { share: 0.0, sd: f64::INFINITY, moved: 0.0 }
    }

    fn or_none(self) -> Self {
        let finite = self.share.is_finite() && self.sd.is_finite() && self.moved.is_finite();
        if finite { self } else { Self::unknown() }
    }

    /// Whether it is more than noise.
    #[must_use]
    pub fn is_significant(&self) -> bool {
        self.share.abs() > SIGNIFICANT * self.sd
    }

    /// Variance that it leaves in the growth rate at small amplitude.
    pub(crate) fn variance(&self) -> f64 {
        (self.sd * self.moved).powi(2)
    }

    /// The same; none where nothing is known of it, and nothing was changed.
    pub(crate) fn variance_if_known(&self) -> f64 {
        if self.sd.is_finite() { self.variance() } else { 0.0 }
    }

    /// Turns the growth rate of a fit without excess into that at small amplitude.
    pub(crate) fn remove(&self, ping: &mut Ping) {
        ping.s.re -= self.share * self.moved;
        ping.covariance[(0, 0)] += self.variance();
    }

    /// The reverse of [`Self::remove`].
    pub(crate) fn put_back(&self, ping: &mut Ping) {
        ping.s.re += self.share * self.moved;
        ping.covariance[(0, 0)] -= self.variance();
    }

    /// The excess that several decays have in common.
    pub(crate) fn common(all: &[Self]) -> Self {
        Several::of(all, |x| x.sd).map_or_else(Self::unknown, |several| Self {
            share: several.mean(|x| x.share),
            sd: several.sd(),
            moved: several.mean(|x| x.moved),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_curve_of_an_endless_decay() {
        // Over 12 decay times of 1e5 rows: integrals of the polynomials under e^{-2u}.
        let (decay, rows) = (6.0, 120_000);
        let step = 12.0 / (decay * rows as f64);
        let Curve { values, slope, spread } = Curve::of(decay, decay, rows, step);
        assert!((slope / decay + 4.0 / 9.0).abs() < 1e-4 && (values[0] - 1.0 / 9.0).abs() < 1e-4);
        // The mean square under the weight is 1/162.
        assert!((spread * step * decay / 0.5 * 162.0 - 1.0).abs() < 1e-3, "{spread}");
        let weights = Excess::weights(decay, rows, step);
        let fallen = |n: usize| (-decay * step * n as f64).exp();
        // Whatever adds x e^{-ct} to the logarithm is found as x.
        let seen: f64 = weights.iter().enumerate().map(|(n, w)| w * fallen(n) * fallen(n)).sum();
        assert!((seen - 1.0).abs() < 1e-9, "{seen}");
    }
}
