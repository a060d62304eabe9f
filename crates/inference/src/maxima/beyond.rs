//! Starts far outside of the prior, for a model that misses the data or contradicts its priors near it.

use super::explore::{Search, misfit};
use crate::fit::Approach;
use rayon::prelude::*;

/// One parameter is moved up to so many standard deviations of its prior from its centre, either way, ...
const FARTHEST: f64 = 32.0;
/// ... in steps of so many.
const STEP: f64 = 2.0;

impl Search<'_> {
    /// Whether a better maximum may lie far outside of the prior: at the best one known the data contradict a
    /// prior, or the model misses them by much more than their measured errors.
    pub(super) fn is_in_doubt(&self) -> bool {
        let (posterior, best) = (self.ground.posterior, self.best());
        let Ok(laplace) = &best.laplace else { return false };
        let conflict = posterior.conflict(&best.fit, laplace);
        conflict.is_ok_and(|conflict| !conflict.warnings().is_empty())
            || posterior.misses(&best.fit).is_ok_and(|misses| misses)
    }

    /// Where one parameter alone is far from the centre of the prior and fits the data better than at the
    /// next step in either direction: at most `most` points, those with the smallest misfit. Parameters of
    /// which an earlier stage has learnt are not moved. None if the prior is improper.
    ///
    /// A sample of the prior, however wide, holds few points at which one parameter alone is far away.
    pub(super) fn beyond(&mut self, most: usize) -> Vec<Approach> {
        let parameters = self.ground.posterior.parameters();
        if parameters.improper().is_some() {
            return Vec::new();
        }
        let (centre, scales) = (parameters.centre(), parameters.scales());
        let steps = (2.0 * FARTHEST / STEP) as usize;
        let free: Vec<usize> = (0..parameters.len()).filter(|&i| !parameters.is_tied(i)).collect();
        let tried: Vec<Vec<Option<Approach>>> = free
            .par_iter()
            .map(|&i| {
                let at = |step: usize| {
                    let mut z = centre.clone();
                    z[i] += (step as f64 * STEP - FARTHEST) * scales[i];
                    self.ground.screen(Some(&parameters.physical(&z))).ok()
                };
                (0..=steps).map(at).collect()
            })
            .collect();
        self.found.calls.value += tried.iter().map(Vec::len).sum::<usize>();
        let mut good: Vec<Approach> = tried.into_iter().flat_map(lowest).collect();
        good.retain(|a| !self.known_at(&a.z));
        good.sort_by(|a, b| misfit(a).total_cmp(&misfit(b)));
        good.truncate(most);
        good.into_iter().map(Approach::counted).collect()
    }
}

/// The points of a line whose misfit is no larger than at both neighbours, without that in the middle.
fn lowest(line: Vec<Option<Approach>>) -> Vec<Approach> {
    let price: Vec<f64> = line.iter().map(|a| a.as_ref().map_or(f64::INFINITY, misfit)).collect();
    let (middle, last) = (price.len() / 2, price.len().saturating_sub(1));
    let is_low = |k: usize| {
        k != middle && price[k] <= price[k.saturating_sub(1)] && price[k] <= price[(k + 1).min(last)]
    };
    line.into_iter().enumerate().filter_map(|(k, a)| a.filter(|_| is_low(k))).collect()
}
