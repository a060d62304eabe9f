//! Ends that feed the modes.

use rijke_study::hertz;

/// An |R| over that of a passive end from which an end is said to feed the modes: one part in a hundred is
/// left for its standard deviation.
const PASSIVE: f64 = 1.01;

/// |R| of the upstream and the downstream end, where a model has them.
pub(in crate::run) struct Reflected {
    pub(in crate::run) moduli: [Option<f64>; 2],
    /// The angular frequency at which it is.
    pub(in crate::run) omega: f64,
    /// Mach number of the flow that leaves, 0 for waves in gas at rest.
    pub(in crate::run) mach: f64,
}

impl Reflected {
    /// The largest |R| of a passive end. Where a flow leaves, waves take (1 + M)^2 |f|^2 out and bring
    /// (1 - M)^2 |g|^2 back (Cantrell & Hart, J. Acoust. Soc. Am. 36 (1964) 697).
    fn passive(&self, end: usize) -> f64 {
        if end == 1 { (1.0 + self.mach) / (1.0 - self.mach) } else { 1.0 }
    }
}

/// What is said of ends that feed the modes.
pub(in crate::run) fn feeding(all: impl Iterator<Item = Reflected>) -> Vec<String> {
    let all: Vec<Reflected> = all.collect();
    let said = |(end, name): (usize, &str)| {
        let over = |r: &Reflected| Some(r.moduli[end]? / r.passive(end)).filter(|over| *over > PASSIVE);
        let feeds = all.iter().filter_map(|r| Some((over(r)?, r)));
        // The first of equal ones.
        let (_, most) = feeds.reduce(|a, b| if b.0 > a.0 { b } else { a })?;
        let (modulus, passive) = (most.moduli[end]?, most.passive(end));
        let limit = if passive > 1.0 {
            format!("{passive:.3}, the largest of a passive end in this flow")
        } else {
            "1".into()
        };
        Some(format!(
            "|R| of the {name} end is {modulus:.3} at {:.1} Hz, above {limit}: this end feeds the modes, as no passive end does; a term that drives them is missing, \
             or growth rates have the wrong sign",
            hertz(most.omega)
        ))
    };
    ["upstream", "downstream"].into_iter().enumerate().filter_map(said).collect()
}

#[cfg(test)]
mod tests {
    use super::{Reflected, feeding};

    #[test]
    fn message_an_end_that_feeds_is_told_by_what_a_passive_one_reflects_in_the_flow() {
        let of = |moduli: [f64; 2], mach: f64| {
            feeding([Reflected { moduli: moduli.map(Some), omega: 600.0, mach }].into_iter())
        };
        assert!(of([1.0, 1.0], 0.0).is_empty() && of([0.9, 1.2], 0.1).is_empty());
        let still = of([0.9, 1.2], 0.0);
        assert!(
            still.len() == 1
                && still[0].starts_with("|R| of the downstream end is 1.200 at 95.5 Hz, above 1:")
        );
        let blown = of([1.1, 1.3], 0.1);
        assert!(blown.len() == 2 && blown[0].contains("upstream end is 1.100"), "{blown:?}");
        assert!(
            blown[1].contains("1.300 at 95.5 Hz, above 1.222, the largest of a passive end"),
            "{blown:?}"
        );
    }
}
