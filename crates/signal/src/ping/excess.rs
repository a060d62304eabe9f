//! Whether the damping of a ring-down depends on its amplitude, as it does where sound separates at holes and
//! open ends, or where a heat release saturates.
//!
//! A loss that grows as the power p of the amplitude, dA/dt = -c A (1 + k A^p), leaves the envelope e^{-ct} /
//! (1 + x (1 - e^{-pct}))^{1/p}: c is the damping at small amplitude, c (1 + x) that at the start. To first
//! order the logarithm of the amplitude gets the part (x/p) e^{-pct}, and one Gauss-Newton step in x alone
//! tells it, as in [`super::chirp`]: what is left of e^{-pct} after 1 and t are projected out is q, which is
//! e^{-pct} less a t and b. The growth rate that a fit without x finds is that at small amplitude and a x/p.
//! An endless record has a = -4/9 c for p = 1, where an excess of one standard deviation moves the growth
//! rate by 2.8, and a = -c/2 for p = 2.
//!
//! A loss that is the same at both signs of the pressure begins with p = 2, one by separation has p = 1. Both
//! are tried. They have different growth rates at small amplitude, so each counts with its likelihood: the
//! growth rate is the mean over both, and its variance holds the square of what they differ by.

use super::slope::{Curve, Several, seen};
use crate::ringdown::{Law, Solution};
use rijke_rig::Ping;

/// By how much the damping exceeds that at small amplitude, by one law of how it grows with the amplitude.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Excess {
    /// At the end of the forcing, as a share of the damping at small amplitude.
    pub share: f64,
    /// Its standard deviation.
    pub sd: f64,
    /// By how much an excess of 1 moves the growth rate of a fit that has none, 1/s.
    pub moved: f64,
    /// Growth rate of a fit that has none, less the one that the linear law says it has, 1/s: none to first
    /// order.
    pub(super) plain: f64,
    /// Twice the logarithm of the likelihood of this law, up to a number that both laws have in common.
    pub(super) support: f64,
}

/// The excess of damping if it grows as the amplitude, and if it grows as its square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Excesses {
    /// As the amplitude.
    pub linear: Excess,
    /// As its square.
    pub square: Excess,
}

/// Standard deviations beyond which an excess is taken as real: noise feigns it in one ping of 16 000.
const SIGNIFICANT: f64 = 4.0;

/// Fewest decay times of a fit that tell of an excess.
const LEAST: f64 = 3.0;

impl Excess {
    /// The excess that a fit by this law has found.
    fn found(found: &Solution) -> Self {
        match (found.components[0].excess, found.curve_covariance(3)) {
            (Some(share), Some([own, mixed])) => {
                let sd = (found.variance() * own).sqrt();
                Self { share, sd, moved: -mixed / own, ..Self::default() }.or_none()
            }
            _ => Self::unknown(),
        }
    }

    /// The excess of a fit that has none, as its residuals show it.
    fn left_by(found: &Solution, left: &[f64], step: f64, law: Law) -> Self {
        let amplitudes = &found.amplitudes[0];
        let rows = left.len() / amplitudes.len().max(1);
        let (s, wave, power) = (found.components[0].s, found.wave(rows, step), f64::from(law.power()));
        let Curve { values, slope, spread } = Curve::of(-s.re * power, -s.re, rows, step);
        let information = 0.5 * found.strength() * spread / (power * power);
        let score = seen(left, amplitudes, &wave, |n| values[n]).re / power;
        let sd = (found.variance() / information).sqrt();
        let share = score / information;
        let support = (share / sd).powi(2);
        Self { share, sd, moved: slope / power, plain: 0.0, support }.or_none()
    }

    /// Weights of the rows of a fit in its excess: times xi/b, where the amplitude is b e^{st} + xi e^{i
    /// omega t}.
    pub(crate) fn weights(decay: f64, rows: usize, step: f64, law: Law) -> Vec<f64> {
        let power = f64::from(law.power());
        let Curve { values, spread, .. } = Curve::of(decay * power, decay, rows, step);
        let (mut fallen, fall) = (power / spread, (-decay * step).exp());
        let weight = |q: f64| {
            let now = q * fallen;
            fallen *= fall;
            now
        };
        values.into_iter().map(weight).collect()
    }

    /// With errors that are so many times as large.
    fn with_larger_error(self, times: f64) -> Self {
        Self { sd: self.sd * times, support: self.support / (times * times), ..self }
    }

    /// Says less of its law where its error was `before` and became larger.
    pub(super) fn lose_support(&mut self, before: f64) {
        if self.sd.is_finite() && self.sd > 0.0 {
            self.support *= (before / self.sd).powi(2);
        }
    }

    fn unknown() -> Self {
        Self { sd: f64::INFINITY, ..Self::default() }
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

    /// Variance that it leaves in the growth rate at small amplitude; none where nothing is known of it, and
    /// nothing was changed.
    fn variance(&self) -> f64 {
        if self.sd.is_finite() { (self.sd * self.moved).powi(2) } else { 0.0 }
    }

    /// Turns the growth rate at small amplitude, of a fit by this law, into that of a fit without excess.
    pub(super) fn put_back(&self, ping: &mut Ping) {
        ping.s.re += self.share * self.moved - self.plain;
        ping.covariance[(0, 0)] -= self.variance();
    }

    /// The excess that several decays have in common.
    fn common(all: &[Self]) -> Self {
        let Some(several) = Several::of(all, |x| x.sd) else { return Self::unknown() };
        let share = several.mean(|x| x.share);
        let apart = |x: &Self| ((x.share - share) / x.sd).powi(2);
        let support = all.iter().map(|x| x.support - apart(x)).sum();
        let (moved, plain) = (several.mean(|x| x.moved), several.mean(|x| x.plain));
        Self { share, sd: several.sd(), moved, plain, support }
    }
}

impl Default for Excesses {
    fn default() -> Self {
        Self { linear: Excess::default(), square: Excess::unknown() }
    }
}

impl Excesses {
    /// The excesses that a fit has found, and one by the `other` law, or, if they were not looked for, that
    /// its residuals `left` show.
    pub(crate) fn of(found: &Solution, other: Option<&Solution>, left: &[f64], step: f64) -> Self {
        let mode = found.components[0];
        if mode.excess.is_none() {
            return Self::left_by(found, left, step);
        }
        let own = Excess::found(found);
        let plain =
            |found: &Solution, excess: &Excess| found.components[0].s.re + excess.share * excess.moved;
        let mut beside = Excess::unknown();
        let mut apart = 0.0;
        if let Some(other) = other {
            beside = Excess::found(other);
            beside.support = (found.residual - other.residual) / found.variance();
            apart = plain(other, &beside) - plain(found, &own);
        }
        match mode.law {
            Law::Linear => Self { linear: own, square: Excess { plain: apart, ..beside } },
            Law::Square => {
                let apart = if beside.sd.is_finite() { -apart } else { 0.0 };
                Self { linear: beside, square: Excess { plain: apart, ..own } }
            }
        }
    }

    /// Those of a fit that has none, as its residuals show them.
    pub(crate) fn left_by(found: &Solution, left: &[f64], step: f64) -> Self {
        let rows = left.len() / found.amplitudes[0].len().max(1);
        if !Self::is_told(found.components[0].s.re, rows, step) {
            return Self { linear: Excess::unknown(), square: Excess::unknown() };
        }
        let by = |law| Excess::left_by(found, left, step, law);
        Self { linear: by(Law::Linear), square: by(Law::Square) }
    }

    /// Whether a fit of so many rows is long enough to tell an excess from a loudspeaker that comes to rest.
    pub(crate) fn is_told(growth_rate: f64, rows: usize, step: f64) -> bool {
        -growth_rate * rows as f64 * step > LEAST
    }

    /// Both, with their laws.
    pub(super) fn each(&mut self) -> [(&mut Excess, Law); 2] {
        [(&mut self.linear, Law::Linear), (&mut self.square, Law::Square)]
    }

    pub(super) fn of_law(&self, law: Law) -> &Excess {
        match law {
            Law::Linear => &self.linear,
            Law::Square => &self.square,
        }
    }

    /// The same for another variance of the noise than that of the fit.
    pub(crate) fn with_variance(self, found: &Solution, variance: f64) -> Self {
        let times = (variance / found.variance()).sqrt();
        let [linear, square] = [self.linear, self.square].map(|x| x.with_larger_error(times));
        Self { linear, square }
    }

    /// The same at a time before the window, when the amplitude was larger by the given factor.
    pub(crate) fn counted_from(self, larger: f64) -> Self {
        let of = |x: Excess, law: Law| {
            let larger = larger.powi(law.power());
            Excess { share: x.share * larger, sd: x.sd * larger, moved: x.moved / larger, ..x }
        };
        Self { linear: of(self.linear, Law::Linear), square: of(self.square, Law::Square) }
    }

    /// How likely each law is, given the other. One of which nothing is known does not count.
    fn weights(&self) -> [f64; 2] {
        let all = [&self.linear, &self.square];
        let best =
            all.iter().filter(|x| x.sd.is_finite()).map(|x| x.support).fold(f64::NEG_INFINITY, f64::max);
        let weights = all.map(|x| if x.sd.is_finite() { (0.5 * (x.support - best)).exp() } else { 0.0 });
        let total = weights[0] + weights[1];
        if total > 0.0 { weights.map(|w| w / total) } else { [1.0, 0.0] }
    }

    /// How likely it is that the excess grows as the square of the amplitude.
    #[must_use]
    pub fn probability_of_square(&self) -> f64 {
        self.weights()[1]
    }

    /// The excess by the likelier law.
    #[must_use]
    pub fn likelier(&self) -> &Excess {
        if self.probability_of_square() > 0.5 { &self.square } else { &self.linear }
    }

    /// Whether anything is known of it.
    #[must_use]
    pub fn is_known(&self) -> bool {
        self.linear.sd.is_finite() || self.square.sd.is_finite()
    }

    /// Whether it is more than noise.
    #[must_use]
    pub fn is_significant(&self) -> bool {
        self.likelier().is_significant()
    }

    /// What is to be added to the growth rate of a decay without excess for that at small amplitude, if its
    /// excesses are these: `own` says how they move it.
    pub(crate) fn shift_of(&self, own: &Self) -> f64 {
        let by = |x: &Excess, own: &Excess| own.plain - x.share * own.moved;
        let [linear, square] = self.weights();
        let mut shift = 0.0;
        for (weight, by) in [(linear, by(&self.linear, &own.linear)), (square, by(&self.square, &own.square))]
        {
            shift += if weight > 0.0 { weight * by } else { 0.0 };
        }
        shift
    }

    /// Variance that the excesses, and their being two, leave in the growth rate at small amplitude.
    pub(crate) fn variance(&self) -> f64 {
        let [linear, square] = self.weights();
        let apart = |x: &Excess| x.plain - x.share * x.moved;
        linear * self.linear.variance()
            + square * self.square.variance()
            + linear * square * (apart(&self.linear) - apart(&self.square)).powi(2)
    }

    /// Turns the growth rate of a fit without excess into that at small amplitude.
    pub(crate) fn remove(&self, ping: &mut Ping) {
        ping.s.re += self.shift_of(self);
        ping.covariance[(0, 0)] += self.variance();
    }

    /// The reverse of [`Self::remove`].
    pub(crate) fn put_back(&self, ping: &mut Ping) {
        ping.s.re -= self.shift_of(self);
        ping.covariance[(0, 0)] -= self.variance();
    }

    /// The excesses that several decays have in common.
    pub(crate) fn common(all: &[Self]) -> Self {
        let of = |law: fn(&Self) -> Excess| Excess::common(&all.iter().map(law).collect::<Vec<_>>());
        Self { linear: of(|x| x.linear), square: of(|x| x.square) }
    }

    /// The support of each law, twice the logarithm of its likelihood.
    pub(crate) fn support(&self) -> [f64; 2] {
        [self.linear.support, self.square.support]
    }

    /// The same with shares and errors that were learnt elsewhere, and with the support that each law has
    /// there.
    pub(crate) fn given(&self, shares: [(f64, f64); 2], support: [f64; 2]) -> Self {
        let of = |x: Excess, (share, sd): (f64, f64), support: f64| Excess { share, sd, support, ..x };
        Self {
            linear: of(self.linear, shares[0], support[0]),
            square: of(self.square, shares[1], support[1]),
        }
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
        let weights = Excess::weights(decay, rows, step, Law::Linear);
        let fallen = |n: usize| (-decay * step * n as f64).exp();
        // Whatever adds x e^{-ct} to the logarithm is found as x.
        let seen: f64 = weights.iter().enumerate().map(|(n, w)| w * fallen(n) * fallen(n)).sum();
        assert!((seen - 1.0).abs() < 1e-9, "{seen}");
    }
    #[test]
    fn exact_curve_of_an_endless_decay_by_the_square() {
        let (decay, rows) = (6.0, 120_000);
        let step = 12.0 / (decay * rows as f64);
        let Curve { values, slope, spread } = Curve::of(2.0 * decay, decay, rows, step);
        assert!((slope / decay + 0.5).abs() < 1e-4 && (values[0] - 0.25).abs() < 1e-4);
        // The mean square under the weight is 1/96 over 1/2.
        assert!((spread * step * decay * 96.0 - 1.0).abs() < 1e-3, "{spread}");
        let weights = Excess::weights(decay, rows, step, Law::Square);
        // Whatever adds x/2 e^{-2ct} to the logarithm is found as x.
        let part = |n: usize| 0.5 * (-3.0 * decay * step * n as f64).exp();
        let seen: f64 = weights.iter().enumerate().map(|(n, w)| w * part(n)).sum();
        assert!((seen - 1.0).abs() < 1e-9, "{seen}");
    }

    #[test]
    fn exact_laws_that_the_record_does_not_tell_apart_leave_their_difference() {
        let of = |share, sd, moved, support| Excess { share, sd, moved, plain: 0.0, support };
        let both = Excesses { linear: of(0.1, 0.01, -4.0, 0.0), square: of(0.1, 0.01, -2.0, 0.0) };
        let mut ping = Ping {
            s: rijke_numerics::C64::new(-10.4, 1e3),
            pressures: vec![rijke_numerics::C64::ONE],
            reference: 0,
            covariance: rijke_numerics::Matrix::identity(2),
        };
        let before = ping.clone();
        both.remove(&mut ping);
        // -10.0 by the one and -10.2 by the other, with 0.04 and 0.02 of its own.
        let variance = 0.5 * (0.04_f64.powi(2) + 0.02_f64.powi(2)) + 0.1_f64.powi(2);
        assert!((ping.s.re + 10.1).abs() < 1e-12, "{}", ping.s.re);
        assert!((ping.covariance[(0, 0)] - 1.0 - variance).abs() < 1e-12);
        both.put_back(&mut ping);
        assert!((ping.s.re - before.s.re).abs() < 1e-12);
        let told = Excesses { square: of(0.1, 0.01, -2.0, 60.0), ..both };
        told.remove(&mut ping);
        assert!((ping.s.re + 10.2).abs() < 1e-9 && told.likelier() == &told.square);
    }
}
