//! A misfit that is nearly as large as what the measured numbers differ by.

use super::apart::Held;
use std::collections::BTreeMap;

/// Part of the scatter of the measured numbers that a misfit may reach before it is said how little the model
/// explains.
const NOTHING: f64 = 0.7;

/// A misfit that is no error of measurement, in measured standard deviations.
const MANY: f64 = 10.0;

/// More than this part of a squared misfit is mostly of one mode.
const MOSTLY: f64 = 0.8;

/// How much of the variance of the numbers called `what` a model explains whose misfit is `misfit`, in a
/// sentence; none where it explains half of it or the numbers hardly differ by more than their standard
/// deviation `sd`. Repeats of one point do not ask for an explanation.
pub(super) fn unexplained(
    what: &str,
    there: &[Held<'_>],
    misfit: f64,
    sd: f64,
    shown: impl Fn(f64) -> String,
) -> Option<String> {
    // Modes of one label have one mean: several modes of a point differ by far more than any misfit.
    let mean = |label: &str| {
        let of_it = || there.iter().filter(|t| t.0.mode.label == label);
        of_it().map(|t| t.1).sum::<f64>() / of_it().count() as f64
    };
    let squares = there.iter().map(|t| (t.1 - mean(&t.0.mode.label)).powi(2)).sum::<f64>();
    let scatter = (squares / there.len() as f64).sqrt();
    if !(scatter > MANY * sd && misfit > MANY * sd && misfit > NOTHING * scatter) {
        return None;
    }
    let left = (misfit / scatter).powi(2);
    let explains = if left < 1.0 {
        format!("explains {:.0} % of their variance; look for what it lacks, and", 100.0 * (1.0 - left))
    } else {
        "explains nothing of their variance;".to_owned()
    };
    Some(format!(
        "{what} scatter by {} (root mean square), and the misfit is {}{}: the model {explains} check units, signs and priors",
        shown(scatter),
        shown(misfit),
        mostly_of(there)
    ))
}

/// Of which mode most of the squared misfit is, in words, where there are several.
fn mostly_of(there: &[Held<'_>]) -> String {
    let mut of_labels: BTreeMap<&str, f64> = BTreeMap::new();
    for (o, measured, predicted) in there {
        *of_labels.entry(o.mode.label.as_str()).or_default() += (measured - predicted).powi(2);
    }
    let all: f64 = of_labels.values().sum();
    let most = of_labels.iter().find(|(_, of_it)| of_labels.len() > 1 && **of_it > MOSTLY * all);
    most.map_or_else(String::new, |(label, of_it)| {
        format!(", {:.0} % of its square in mode {label}", 100.0 * of_it / all)
    })
}
