//! Poles of laws that are formulas: the zeros of what they divide by.

use rijke_formula::Formula;
use rijke_network::{Pole, Region, zeros_of};
use rijke_numerics::C64;
use rijke_study::names::{FLANGED, LEVINE_SCHWINGER, WALL_EP, WALL_MU};

/// Samples from one mode to the next at least, along the border of a region: laws of devices seldom vary as
/// fast as waves, and where they do more samples are taken.
pub(super) const SAMPLES: f64 = 20.0;

/// The same of laws of powers and roots of s, which have no length of their own: what varies fast is near a
/// zero, and the slopes show it.
const FEWER: f64 = 2.0;

/// Poles of one place that are one, relative to |s|.
const SAME: f64 = 1e-6;

/// A law at a place, and how its parts are evaluated.
pub(crate) struct Acting {
    /// Number of the law.
    pub(crate) law: usize,
    /// Laws that share this share poles: those of one candidate at one place.
    pub(crate) owner: [usize; 2],
    pub(crate) formula: Formula,
}

/// The poles of the laws in a region, where modes lie about `spacing` from each other, rad/s. `evaluate`
/// gives a part of a law and its derivative at s. Of a part whose zeros cannot be found there are none; the
/// count of modes then says that a pole is missing.
pub(crate) fn poles(
    laws: &[Acting],
    region: &Region,
    spacing: f64,
    evaluate: impl Fn(usize, &Formula, C64) -> [C64; 2],
) -> Vec<Pole> {
    let mut all: Vec<(Pole, [usize; 2])> = Vec::new();
    for Acting { law, owner, formula } in laws {
        let mut found: Vec<(C64, usize)> = Vec::new();
        for part in formula.divisors() {
            if [WALL_MU, WALL_EP, LEVINE_SCHWINGER, FLANGED].iter().any(|name| part.uses(*name)) {
                continue;
            }
            let samples = if part.is_algebraic() { FEWER } else { SAMPLES };
            let zeros = zeros_of(|s| evaluate(*law, &part, s), region, spacing / samples, found.clone());
            let new = |z: &(C64, usize)| found.iter().all(|f| (f.0 - z.0).norm() > SAME * z.0.norm());
            let zeros: Vec<_> = zeros.unwrap_or_default().into_iter().filter(new).collect();
            found.extend(zeros);
        }
        for (at, order) in found {
            // The network has the poles of one element once, in whichever coefficient.
            let same = |(p, o): &(Pole, [usize; 2])| o == owner && (p.at - at).norm() < SAME * at.norm();
            if !all.iter().any(same) {
                all.push((Pole { law: *law, at, order }, *owner));
            }
        }
    }
    all.into_iter().map(|(pole, _)| pole).collect()
}

#[cfg(test)]
mod tests {
    use super::{Acting, poles};
    use rijke_formula::{Context, Formula, Here, Scope};
    use rijke_network::Region;
    use rijke_numerics::{C64, ComplexDual, JetSpace, Order};

    /// Two resonators in one law, sharp and blunt ones, at places that a fixed sequence spreads: the poles
    /// are the roots of two quadratics.
    #[test]
    fn exact_poles_of_resonators_are_the_roots_of_their_quadratics() {
        let scope = Scope::new();
        let parameters = ["a", "b", "c", "d"].map(str::to_owned);
        let context = Context { scope: &scope, here: &|_| true, parameters: &parameters, definitions: &[] };
        let text = "1/((s^2 + 2*a*s + a^2 + b^2)*(s^2 + 2*c*s + c^2 + d^2))";
        let law = Formula::parse(text, &context).unwrap();
        let region = Region { sigma: [-400.0, 50.0], omega: [100.0, 4000.0] };
        let spacing = 1500.0;
        let share = |k: usize, step: f64| (k as f64 * step).fract();
        let mut inside = 0;
        for k in 0..400 {
            // Decay from 0.1 to 1000 1/s.
            let at = |p: f64, q: f64| (10.0_f64.powf(4.0 * share(k, p) - 1.0), 4300.0 * share(k, q));
            let [(a, b), (c, d)] = [at(0.618_034, 0.754_878), at(0.569_840, 0.819_173)];
            let acting = Acting { law: 0, owner: [0, 0], formula: law.of_s(&[f64::NAN], &[a, b, c, d]) };
            let found = poles(&[acting], &region, spacing, |_, part, s| {
                let s = ComplexDual { value: s, slope: C64::ONE };
                let space = JetSpace::new(1, Order::First);
                let here = Here { space, numbers: &[f64::NAN], analytic: &[Some(&s)] };
                let value = part.evaluate_in_s(&here, &[]);
                [value.value, value.slope]
            });
            let wanted: Vec<C64> = [C64::new(-a, b), C64::new(-c, d)]
                .into_iter()
                .filter(|z| {
                    (region.sigma[0]..region.sigma[1]).contains(&z.re)
                        && (region.omega[0]..region.omega[1]).contains(&z.im)
                })
                .collect();
            inside += wanted.len();
            assert_eq!(found.len(), wanted.len(), "{a} {b} {c} {d}: {found:?}");
            for z in wanted {
                assert!(found.iter().any(|p| (p.at - z).norm() < 1e-9 * z.norm()), "{z}: {found:?}");
            }
        }
        assert!(inside > 500, "{inside}");
    }
}
