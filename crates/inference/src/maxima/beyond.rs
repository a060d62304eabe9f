//! Starts far outside of the prior, for a model that misses the data or contradicts its priors near it.

use super::explore::{Search, misfit};
use super::terrain::Peak;
use crate::density::Calls;
use crate::fit::Approach;
use rayon::prelude::*;

/// How far one parameter is moved from the centre of its prior in either direction, and in steps of what:
/// prior standard deviations.
const FARTHEST: f64 = 32.0;
const STEP: f64 = 2.0;

impl Search<'_> {
    /// Whether a better maximum may lie far outside of the prior: at this end of a search the data contradict
    /// a prior, or the model misses them by much more than their measured errors.
    pub(super) fn is_in_doubt(&self, peak: &Peak) -> bool {
        let posterior = self.ground.posterior;
        let Ok(laplace) = &peak.laplace else { return false };
        let conflict = posterior.conflict(&peak.fit, laplace);
        conflict.is_ok_and(|conflict| !conflict.warnings().is_empty())
            || posterior.misses(&peak.fit).is_ok_and(|misses| misses)
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
        // Their calls are counted.
        good.into_iter().map(|a| Approach { calls: Calls::default(), ..a }).collect()
    }
}

/// The points of a line whose misfit is no larger than at both neighbours, without that in the middle.
fn lowest(line: Vec<Option<Approach>>) -> Vec<Approach> {
    let price: Vec<f64> = line.iter().map(|a| a.as_ref().map_or(f64::INFINITY, misfit)).collect();
    let at = |k: Option<usize>| k.and_then(|k| price.get(k)).copied().unwrap_or(f64::INFINITY);
    let low = |k: usize| price[k] <= at(k.checked_sub(1)).min(at(Some(k + 1)));
    let low: Vec<bool> = (0..price.len()).map(|k| k != price.len() / 2 && low(k)).collect();
    line.into_iter().zip(low).filter_map(|(a, low)| a.filter(|_| low)).collect()
}
