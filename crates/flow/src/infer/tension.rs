//! What readings say of a closure that handbooks leave open.

use serde::{Deserialize, Serialize};

/// What the readings say of one closure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClosureTension {
    /// Name of the closure.
    pub closure: String,
    /// Its value in the fit.
    pub value: f64,
    /// The value that the readings prefer, to first order.
    pub preferred: f64,
    /// Sd of that.
    pub sd: f64,
    /// Standard normal if the closure is right.
    pub z: f64,
}

impl ClosureTension {
    /// More than three sd away: with eight closures, one right model in fifty is called wrong.
    #[must_use]
    pub fn is_wrong(&self) -> bool {
        self.z.abs() > 3.0
    }

    /// What several runs with the same closures say together: means weighted by 1/sd^2, closure by closure.
    /// An error too small to be seen at one place of the heater is seen at fifteen.
    #[must_use]
    pub fn together(runs: &[&[ClosureTension]]) -> Vec<ClosureTension> {
        let Some(first) = runs.first() else { return Vec::new() };
        let one = |t: &ClosureTension| {
            let same = runs.iter().flat_map(|run| run.iter().filter(|o| o.closure == t.closure));
            let (weight, shift) = same.fold((0.0, 0.0), |(weight, shift), o| {
                let w = o.sd.powi(-2);
                (weight + w, shift + w * (o.preferred - o.value))
            });
            let sd = f64::sqrt(weight).recip();
            let (preferred, z) = (t.value + shift / weight, shift / weight / sd);
            ClosureTension { closure: t.closure.clone(), value: t.value, preferred, sd, z }
        };
        first.iter().map(one).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_runs_add_up_by_weight() {
        let run = |preferred: f64, sd: f64| {
            let (closure, value) = ("emissivity".to_owned(), 0.3);
            vec![ClosureTension { closure, value, preferred, sd, z: (preferred - value) / sd }]
        };
        let runs = [run(0.4, 0.05), run(0.5, 0.1)];
        let all = ClosureTension::together(&[&runs[0], &runs[1]]);
        // Weights 400 and 100: shift 0.12 with sd 1/sqrt(500).
        assert!((all[0].preferred - 0.42).abs() < 1e-12 && (all[0].z - 0.12 * 500_f64.sqrt()).abs() < 1e-9);
    }
}
