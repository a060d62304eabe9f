//! Which points to measure together: greedily, then by exchange.

use crate::EngineError;
use rayon::prelude::*;
use rijke_numerics::InOrder;

/// Lowest relative gain for which points are exchanged: above rounding.
const WORTH: f64 = 1e-9;

/// What a set of visits would tell, and what it costs.
pub(super) struct Worth<'a> {
    /// Nats.
    pub(super) gain: &'a (dyn Fn(&[usize]) -> Result<f64, EngineError> + Sync),
    /// Hours, or visits.
    pub(super) cost: &'a (dyn Fn(&[usize]) -> f64 + Sync),
}

impl Worth<'_> {
    fn rate(&self, set: &[usize]) -> Result<f64, EngineError> {
        Ok((self.gain)(set)? / (self.cost)(set))
    }

    /// Of `candidates`, which may come twice, the one that adds most to `set` for what it costs.
    pub(super) fn next(&self, candidates: &[usize], set: &[usize]) -> Result<Option<usize>, EngineError> {
        let (gain, cost) = self.value(set)?;
        let with = |k: &usize| self.value(&[set, &[*k]].concat());
        let all = candidates.par_iter().map(with).in_order::<Result<Vec<_>, _>>()?;
        let mut best: Option<(usize, f64)> = None;
        for (&k, (more, dearer)) in candidates.iter().zip(all) {
            let rate = (more - gain) / (dearer - cost);
            if best.is_none_or(|(_, b)| rate > b) {
                best = Some((k, rate));
            }
        }
        Ok(best.map(|(k, _)| k))
    }

    fn value(&self, set: &[usize]) -> Result<(f64, f64), EngineError> {
        if set.is_empty() { Ok((0.0, 0.0)) } else { Ok(((self.gain)(set)?, (self.cost)(set))) }
    }

    /// `count` visits, each the best after those before it.
    pub(super) fn greedy(&self, candidates: &[usize], count: usize) -> Result<Vec<usize>, EngineError> {
        let mut set = Vec::new();
        while set.len() < count
            && let Some(k) = self.next(candidates, &set)?
        {
            set.push(k);
        }
        Ok(set)
    }

    /// The set after every exchange of one visit for another that raises what all visits tell for what they
    /// cost (Fedorov 1972), the best exchange first, until none does.
    pub(super) fn exchanged(
        &self,
        candidates: &[usize],
        mut set: Vec<usize>,
    ) -> Result<Vec<usize>, EngineError> {
        if set.is_empty() {
            return Ok(set);
        }
        let mut rate = self.rate(&set)?;
        loop {
            let exchange = |(place, k): (usize, usize)| {
                let mut other = set.clone();
                other[place] = k;
                let found = self.rate(&other)?;
                Ok((other, found))
            };
            let of = |place: usize| candidates.iter().map(move |&k| (place, k));
            let others: Vec<(usize, usize)> =
                (0..set.len()).flat_map(of).filter(|(place, k)| *k != set[*place]).collect();
            let others = others.into_par_iter().map(exchange).in_order::<Result<Vec<_>, EngineError>>()?;
            let mut best: Option<(Vec<usize>, f64)> = None;
            for (other, found) in others {
                if found > best.as_ref().map_or(rate + WORTH * rate.abs(), |(_, r)| *r) {
                    best = Some((other, found));
                }
            }
            // Every exchange raises the rate, and there are finitely many sets.
            match best {
                Some((other, found)) => (set, rate) = (other, found),
                None => return Ok(set),
            }
        }
    }

    /// The visits of a set in the order in which each adds most after those before it.
    pub(super) fn ordered(&self, set: &[usize]) -> Result<Vec<usize>, EngineError> {
        let (mut left, mut done) = (set.to_vec(), Vec::new());
        while let Some(k) = self.next(&left, &done)? {
            if let Some(place) = left.iter().position(|l| *l == k) {
                left.remove(place);
            }
            done.push(k);
        }
        Ok(done)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rijke_numerics::{Cholesky, Matrix};

    /// Information about two parameters that are known to 1, from numbers with noise of 1 and these slopes.
    const SLOPES: [[f64; 2]; 3] = [[2.1, 2.1], [2.9, 0.0], [0.0, 2.9]];

    fn gain(set: &[usize]) -> Result<f64, EngineError> {
        let mut m = Matrix::identity(2);
        set.iter().for_each(|&k| m.add_outer(&SLOPES[k]));
        Ok(0.5 * Cholesky::new(&m)?.ln_det())
    }

    /// The point that is best alone is not among the two that are best together, and greed cannot take it
    /// back.
    #[test]
    fn exact_exchange_finds_the_pair_that_greed_misses() {
        let worth = Worth { gain: &gain, cost: &|set| set.len() as f64 };
        let greedy = worth.greedy(&[0, 1, 2], 2).unwrap();
        assert_eq!(greedy[0], 0);
        let mut best = worth.exchanged(&[0, 1, 2], greedy.clone()).unwrap();
        best.sort_unstable();
        assert_eq!(best, [1, 2]);
        assert!(gain(&best).unwrap() > gain(&greedy).unwrap());
        let costs = |set: &[usize]| set.iter().map(|&k| if k == 0 { 1.0 } else { 3.0 }).sum();
        let dear = Worth { gain: &gain, cost: &costs };
        for count in 1..4 {
            let greedy = dear.greedy(&[0, 1, 2], count).unwrap();
            let best = dear.exchanged(&[0, 1, 2], greedy.clone()).unwrap();
            let rate = |set: &[usize]| gain(set).unwrap() / costs(set);
            assert!(rate(&best) >= rate(&greedy));
            let order = dear.ordered(&best).unwrap();
            assert_eq!(order.len(), best.len());
        }
    }
}
