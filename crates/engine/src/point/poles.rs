//! Poles of laws that are formulas: the zeros of what they divide by.

use rijke_formula::Formula;
use rijke_network::{Pole, Region, zeros_of};
use rijke_numerics::C64;
use rijke_study::names::{FLANGED, LEVINE_SCHWINGER, WALL_EP, WALL_MU};

/// Samples from one mode to the next at least, along the border of a region: laws of devices seldom vary as
/// fast as waves, and where they do more samples are taken.
pub(super) const SAMPLES: f64 = 20.0;

/// Poles of one place that are one, relative to |s|.
const SAME: f64 = 1e-6;

/// A law at a place, and how its parts are evaluated.
pub(crate) struct Acting<'a> {
    /// Number of the law.
    pub(crate) law: usize,
    /// Laws that share this share poles: those of one candidate at one place.
    pub(crate) owner: [usize; 2],
    pub(crate) formula: &'a Formula,
}

/// The poles of the laws in a region, where modes lie about `spacing` from each other, rad/s. `evaluate`
/// gives a part of a law and its derivative at s. Of a part whose zeros cannot be found there are none; the
/// count of modes then says that a pole is missing.
pub(crate) fn poles(
    laws: &[Acting<'_>],
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
            let zeros = zeros_of(|s| evaluate(*law, &part, s), region, spacing / SAMPLES, found.clone());
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
