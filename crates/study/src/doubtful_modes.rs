//! Rows of modes that are most often slips: growth rates of zero or with the other sign, and copies.

use crate::{Campaign, ObservedModes};
use rijke_numerics::words::few;
use std::collections::HashMap;

/// Most points that are named.
const NAMED: usize = 5;
/// So many modes that all grow are no campaign.
const MANY: usize = 4;

impl ObservedModes {
    /// Modes whose growth rate is exactly zero, in a sentence: what keeps its amplitude by itself is no mode
    /// that neither grows nor decays.
    #[must_use]
    pub fn steady(&self, campaign: &Campaign) -> Option<String> {
        let zero = self.modes.iter().filter(|m| m.growth_rate == Some(0.0));
        let points: Vec<&str> = zero.map(|m| campaign.points[m.point].id.as_str()).collect();
        (!points.is_empty()).then(|| {
            format!(
                "the growth rate is exactly 0 at {}: an oscillation that keeps its amplitude by itself is that of a mode which grows while it is small; \
                 leave the cell empty where neither decay nor growth was measured",
                few(&points, NAMED)
            )
        })
    }

    /// That no growth rate is negative, in a sentence: only modes that decay ring down, and most often the
    /// column holds another number of the decay.
    #[must_use]
    pub fn none_decays(&self) -> Option<String> {
        let rates: Vec<f64> = self.modes.iter().filter_map(|m| m.growth_rate).collect();
        (rates.len() >= MANY && rates.iter().all(|g| *g > 0.0)).then(|| {
            format!(
                "all {} growth rates are positive, so that every mode grows: if the column holds decay rates, widths at half power, quality factors or \
                 reverberation times, write the growth rates that follow from them, which are negative",
                rates.len()
            )
        })
    }

    /// Which points have the numbers of an earlier one to the last digit, in a sentence: a row that was
    /// copied counts as a measurement of its own, and makes what is trained too certain.
    #[must_use]
    pub fn copied(&self, campaign: &Campaign) -> Option<String> {
        let point = |k: usize| &campaign.points[self.modes[k].point];
        // A lone number may come twice by rounding, unless all else is equal too.
        let alike = |a: usize, b: usize| {
            let bits = |k: usize| self.modes[k].numbers().iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            let set = |k: usize| point(k).factors.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            bits(a) == bits(b) && (bits(a).len() > 2 || set(a) == set(b))
        };
        let mut by_numbers: HashMap<Vec<u64>, Vec<usize>> = HashMap::new();
        let mut pairs = Vec::new();
        for (k, mode) in self.modes.iter().enumerate().filter(|(_, m)| !m.numbers().is_empty()) {
            let bits = mode.numbers().iter().map(|x| x.to_bits()).collect();
            let earlier = by_numbers.entry(bits).or_default();
            pairs.extend(earlier.iter().find(|e| alike(**e, k)).map(|e| (*e, k)));
            earlier.push(k);
        }
        let (first, copy) = *pairs.first()?;
        // Of two modes of one point the point alone says nothing.
        let named = |k: usize| match self.modes[k].label.as_str() {
            label if point(first).id == point(copy).id => format!("{} (mode {label})", point(k).id),
            _ => point(k).id.clone(),
        };
        Some(format!(
            "{} has the same numbers as {} to the last digit{}: if a row was copied, take the copy out, because each counts as a measurement of its \
             own",
            named(copy),
            named(first),
            if pairs.len() > 1 { format!(" ({} rows are such copies)", pairs.len()) } else { String::new() }
        ))
    }
}
