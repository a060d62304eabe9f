//! Whether the frequency of a ring-down drifts while it decays, as it does when the gas warms or cools.
//!
//! With a drift chi (rad/s^2) the amplitude of every channel is b_m e^{s t + i chi t^2 / 2}. The fit without
//! chi is the maximum of the likelihood in s and b, so one Gauss-Newton step in chi alone tells it: what is
//! left of the derivative i b_m t^2 / 2 after the derivatives in b (1) and s (t) are projected out is i b_m q
//! / 2, q = t^2 - a t - c, with a and c of the weighted least squares under e^{2 sigma t}. Terms at twice the
//! frequency are left out, an error of about |sigma|/omega, and so are the neighbours. A drift that is seen
//! so is fitted, with all else, as a free number of the mode. For an endless record
//! a/2 is one decay time: the fit without chi has found the frequency of that moment.

use super::slope::{Several, seen};
use crate::ringdown::Solution;
use rijke_rig::Ping;

/// Drift of the angular frequency of a mode during its decay.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Drift {
    /// Change of the angular frequency with time, rad/s^2. Over the angular frequency: the relative change of
    /// the speed of sound, 1/s.
    pub rate: f64,
    /// Its standard deviation.
    pub sd: f64,
    /// The moment whose frequency a fit without drift finds, s after the end of the forcing.
    pub moment: f64,
    /// How well that end is known, s.
    pub unsure: f64,
}

/// Standard deviations beyond which a drift is taken as real: noise feigns it in one ping of 16 000.
const SIGNIFICANT: f64 = 4.0;

impl Drift {
    /// The drift that a fit has found, or, if it was not looked for, that its residuals `left` show.
    pub(crate) fn of(found: &Solution, left: &[f64], step: f64) -> Self {
        match (found.components[0].chirp, found.curve_covariance(2)) {
            (Some(rate), Some([own, mixed])) => {
                let sd = (found.variance() * own).sqrt();
                Self { rate, sd, moment: -mixed / own, unsure: 0.0 }.or_none()
            }
            _ => Self::left_by(found, left, step),
        }
    }

    /// Weights of the rows of a fit in its drift: times xi/b, where the amplitude is b e^{st} + xi e^{i omega
    /// t}.
    pub(crate) fn weights(decay: f64, rows: usize, step: f64) -> Vec<f64> {
        let ([a, c], spread) = curve(decay, rows, step);
        let weight = |n: usize| {
            let t = n as f64 * step;
            2.0 * (t * t - a * t - c) * (-decay * t).exp() / spread
        };
        (0..rows).map(weight).collect()
    }

    /// The drift of a fit that has none, as its residuals show it.
    pub(crate) fn left_by(found: &Solution, left: &[f64], step: f64) -> Self {
        let (s, amplitudes, variance) = (found.components[0].s, &found.amplitudes[0], found.variance());
        let rows = left.len() / amplitudes.len().max(1);
        let ([a, c], spread) = curve(-s.re, rows, step);
        let information = 0.125 * found.strength() * spread;
        let weight = |n: usize| {
            let t = n as f64 * step;
            -0.5 * (t * t - a * t - c)
        };
        let score = seen(left, amplitudes, &found.wave(rows, step), weight).im;
        let sd = (variance / information).sqrt();
        Self { rate: score / information, sd, moment: 0.5 * a, unsure: 0.0 }.or_none()
    }

    /// The same for another variance of the noise than that of the fit.
    pub(crate) fn with_variance(self, found: &Solution, variance: f64) -> Self {
        Self { sd: self.sd * (variance / found.variance()).sqrt(), ..self }
    }

    /// The same, its moment counted from a time `since` before the start of the window, known to `unsure`, s.
    pub(crate) fn counted_from(self, since: f64, unsure: f64) -> Self {
        Self { moment: self.moment + since, unsure, ..self }
    }

    fn unknown() -> Self {
        Self { rate: 0.0, sd: f64::INFINITY, moment: 0.0, unsure: 0.0 }
    }

    fn or_none(self) -> Self {
        let finite = self.rate.is_finite() && self.sd.is_finite() && self.moment.is_finite();
        if finite { self } else { Self::unknown() }
    }

    /// Whether it is more than noise.
    #[must_use]
    pub fn is_significant(&self) -> bool {
        self.rate.abs() > SIGNIFICANT * self.sd
    }

    /// Variance that it leaves in the frequency at the end of the forcing.
    pub(crate) fn variance(&self) -> f64 {
        (self.sd * self.moment).powi(2) + (self.rate * self.unsure).powi(2)
    }

    /// The same; none where nothing is known of it, and nothing was changed.
    pub(crate) fn variance_if_known(&self) -> f64 {
        if self.sd.is_finite() { self.variance() } else { 0.0 }
    }

    /// Turns the frequency of a fit without drift into that at the end of the forcing.
    pub(crate) fn remove(&self, ping: &mut Ping) {
        ping.s.im -= self.rate * self.moment;
        ping.covariance[(1, 1)] += self.variance();
    }

    /// The reverse of [`Self::remove`].
    pub(crate) fn put_back(&self, ping: &mut Ping) {
        ping.s.im += self.rate * self.moment;
        ping.covariance[(1, 1)] -= self.variance();
    }

    /// The drift that several decays have in common.
    pub(crate) fn common(drifts: &[Self]) -> Self {
        Several::of(drifts, |d| d.sd).map_or_else(Self::unknown, |several| Self {
            rate: several.mean(|d| d.rate),
            sd: several.sd(),
            moment: several.mean(|d| d.moment),
            unsure: several.mean(|d| d.unsure),
        })
    }
}

/// The numbers a and c of q = t^2 - a t - c, at right angles to 1 and t under e^{-2 decay t}, and the sum of
/// its squares under it.
fn curve(decay: f64, rows: usize, step: f64) -> ([f64; 2], f64) {
    let mut moments = [0.0; 5];
    let (shrink, mut weight) = ((-2.0 * decay * step).exp(), 1.0);
    for n in 0..rows {
        let (t, mut term) = (n as f64 * step, weight);
        for moment in &mut moments {
            *moment += term;
            term *= t;
        }
        weight *= shrink;
    }
    let [m0, m1, m2, m3, m4] = moments;
    let determinant = m2 * m0 - m1 * m1;
    let (a, c) = ((m3 * m0 - m2 * m1) / determinant, (m2 * m2 - m1 * m3) / determinant);
    ([a, c], m4 - a * m3 - c * m2)
}
