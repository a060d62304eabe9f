//! From one maximum to the others that aliases of the model lead to.

use super::explore::{Open, Origin, Search};
use super::terrain::Peak;
use crate::fit::Approach;

/// Rounds in which the images of a new best maximum are looked at.
const ROUNDS: usize = 3;
/// Most maxima beside the best whose images are looked at.
const FAMILIES: usize = 8;
/// Most of the evidence that images together may hold and be left out.
const LEFT_OUT: f64 = 1e-3;

impl Search<'_> {
    /// Descends from the images of the best maximum, a few times if these lead to better ones, and from those
    /// of every other to which no image led; and from where a noise is small. The last of these alone take
    /// from the starts that are `left`. Of the images of the best, `least` are looked at in any case.
    pub(super) fn follow_images(&mut self, left: &mut usize, least: usize) {
        loop {
            let best = self.best_place();
            let z = self.found.peaks[best].z.clone();
            if self.bests.len() < ROUNDS && !self.bests.contains(&z) {
                self.bests.push(z);
                self.imaged[best] = true;
                let small = self.ground.with_less_noise(&self.found.peaks[best].fit);
                let mut near = self.screened(&small.iter().map(|s| Some(s.as_slice())).collect::<Vec<_>>());
                near.retain(|a| !self.known_at(&a.z));
                near.truncate(*left);
                *left -= near.len();
                self.follow_images_of(best, least);
                self.batch(near, Origin::Own);
                continue;
            }
            let fresh = |k: &usize| !self.imaged[*k] && self.found.peaks[*k].converged;
            let Some(next) = (0..self.imaged.len()).find(fresh) else { break };
            self.imaged[next] = true;
            if self.families == FAMILIES {
                continue;
            }
            self.families += 1;
            self.follow_images_of(next, 0);
        }
    }

    /// Descends from the images of a peak, in the order of what they may hold of the evidence, down to those
    /// that together hold less than [`LEFT_OUT`] of it, and from `least` of them.
    ///
    /// An image has the likelihood of the peak as far as the alias is exact, and a search from it ends no
    /// lower than it begins: what it may hold is the larger of the two.
    fn follow_images_of(&mut self, peak: usize, least: usize) {
        let Peak { fit, cost, ln_marginal, .. } = &self.found.peaks[peak];
        let (cost, own) = (*cost, *ln_marginal);
        let images = self.ground.images(fit);
        if images.list.is_empty() {
            return;
        }
        // What is known already, in nats above the peak.
        let known = self.found.peaks.iter().filter_map(|p| Some(p.ln_marginal? - own?));
        let known: Vec<f64> = known.collect();
        let weights: Vec<f64> = images.list.iter().map(|(_, above)| *above).collect();
        // Those that were not formed fall off as fast as those that were.
        let all: Vec<f64> = images.rest.map_or(Vec::new(), |rest| vec![rest; weights.len()]);
        if needed(&all, &[known.as_slice(), &weights].concat()) > 0 {
            self.found.open = Some(Open::ManyImages);
        }
        let count = if least == 0 { needed(&weights, &known) } else { weights.len() };
        let starts: Vec<Option<&[f64]>> =
            images.list[..count].iter().map(|(values, _)| Some(values.as_slice())).collect();
        let before = self.found.starts;
        let screened = self.screened(&starts);
        // Those at which the model fails.
        self.of_images[0] += self.found.starts - before;
        let mut weighed: Vec<(Approach, f64)> = Vec::with_capacity(screened.len());
        for at in screened.into_iter().filter(|at| !self.known_at(&at.z)) {
            let weight = self.ground.above(&at.z, &self.found.peaks[peak].fit).max(cost - at.cost);
            weighed.push((at, weight));
        }
        weighed.sort_by(|a, b| b.1.total_cmp(&a.1));
        let weights: Vec<f64> = weighed.iter().map(|(_, weight)| *weight).collect();
        weighed.truncate(needed(&weights, &known).max(least));
        self.batch(weighed.into_iter().map(|(at, _)| at).collect(), Origin::Image);
    }
}

/// How many of these `weights`, largest first, are needed beside the `known` ones until the others hold less
/// than [`LEFT_OUT`] of all; logarithms.
fn needed(weights: &[f64], known: &[f64]) -> usize {
    let highest = weights.iter().chain(known).copied().fold(f64::NEG_INFINITY, f64::max);
    let of = |ln: &f64| (ln - highest).exp();
    let whole = weights.iter().chain(known).map(of).sum::<f64>();
    let mut rest = 0.0;
    let least = weights.iter().rev().take_while(|ln| {
        rest += of(ln);
        rest <= LEFT_OUT * whole
    });
    weights.len() - least.count()
}

#[cfg(test)]
mod tests {
    use super::needed;

    #[test]
    fn exact_what_is_left_out_is_less_than_a_thousandth() {
        let halves: Vec<f64> = (0..40).map(|k| -f64::from(k) * std::f64::consts::LN_2).collect();
        // The rest after n halvings is 2^-n of all: ten make 1/1024.
        assert_eq!(needed(&halves, &[]), 10);
        assert_eq!(needed(&halves, &[f64::ln(1e4)]), 0);
        assert_eq!(needed(&[-2000.0, -2001.0], &[]), 2);
        assert_eq!(needed(&[], &[]), 0);
    }
}
