//! Rows of modes that are most often slips: growth rates of zero, and copies.

use crate::{Campaign, ObservedModes};
use rijke_numerics::words::few;
use std::collections::HashMap;

/// Most points that are named.
const NAMED: usize = 5;

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
        Some(format!(
            "{} has the same numbers as {} to the last digit{}: if a row was copied, take the copy out, because each counts as a measurement of its \
             own",
            point(copy).id,
            point(first).id,
            if pairs.len() > 1 { format!(" ({} rows are such copies)", pairs.len()) } else { String::new() }
        ))
    }
}
