//! Scores of all terms, families of those that are alike, and what chance would do.

use super::library::{Library, Term};
use crate::run::found::{Asked, Family, Missing, words};
use rayon::prelude::*;
use rijke_inference::{Linearised, Told, gain};
use rijke_numerics::{Matrix, Streams, dot};
use std::borrow::Borrow;
use std::collections::{BTreeMap, BTreeSet};

/// Directions of a larger correlation belong to one family.
const ALIKE: f64 = 0.9;

/// Terms by which an effect at a place is judged, at most.
const OF_AN_EFFECT: usize = 4;

/// Terms that are taken one after the other, at most: several may be of one effect.
const TAKEN: usize = 24;

/// Families that are told.
const TOLD: usize = 6;

/// Data sets that are drawn.
const DRAWS: usize = 1000;

pub(super) fn judged(
    linear: &Linearised,
    library: Library,
    rows: &[(usize, usize)],
    observations: usize,
) -> Option<Missing> {
    let told: Vec<Option<Told>> = library.directions.par_iter().map(|d| linear.told(d)).collect();
    let all = library.terms.into_iter().zip(library.directions).zip(told);
    let mut found: Vec<Found> =
        all.filter_map(|((term, direction), told)| Some(Found { term, direction, told: told? })).collect();
    let gain = |f: &Found| f.told.gain(f.told.drop[1], observations);
    found.sort_by(|a, b| gain(b).total_cmp(&gain(a)));
    let chance = by_chance(linear, &found, observations);
    let probability = |gain: f64| {
        let exceeded = chance.iter().filter(|best| **best >= gain).count();
        (1.0 + exceeded as f64) / (1.0 + chance.len() as f64)
    };
    let asked = |Found { term, direction, told }: &Found| {
        let rms = |row: usize| {
            let all = direction.iter().zip(rows).filter(|(_, r)| r.1 == row);
            let (sum, n) = all.fold((0.0, 0), |(sum, n), (d, _)| (sum + (d * told.strength).powi(2), n + 1));
            if n == 0 { 0.0 } else { (sum / f64::from(n)).sqrt() }
        };
        Asked {
            effect: term.effect.clone(),
            place: term.place.clone(),
            x: term.x,
            times: term.times.clone(),
            strength: [told.strength, told.sd],
            unit: term.unit.clone().into_owned(),
            prior_sd: told.prior_sd(observations),
            gain: told.gain(told.drop[1], observations),
            probability: probability(told.gain(told.drop[0], observations)),
            moves: [rms(0), rms(1)],
        }
    };
    let mut families: Vec<Family> = Vec::new();
    let mut left = Left::of(&found, observations);
    let expected = expected(&found);
    // The effects of which these are.
    let mut effects: Vec<[&str; 2]> = Vec::new();
    for _ in 0..TAKEN {
        let Some((k, most)) = left.best().filter(|_| families.len() < TOLD) else { break };
        let first = &found[k];
        let alike = |j: &usize| {
            let product = dot(&found[*j].direction, &first.told.pulled);
            (product * first.told.sd * found[*j].told.sd).abs() > ALIKE
        };
        let all: Vec<usize> = (0..found.len()).filter(|j| !left.taken[*j]).filter(alike).collect();
        let shown = left.most_probable(&found, &all, &expected).unwrap_or(k);
        let (first, beyond) = (&found[shown], left.gain(shown));
        let members: Vec<usize> = all.into_iter().filter(|j| *j != shown).collect();
        left.take(&found, shown, &members);
        if let Some(family) = effects.iter().position(|e| *e == first.term.whole()) {
            if probability(most) <= Missing::CHANCE {
                families[family].also.push(first.term.words());
            }
            continue;
        }
        effects.push(first.term.whole());
        let xs = members.iter().map(|&j| &found[j].term).filter(|t| t.effect == first.term.effect);
        let xs: Vec<f64> = xs.filter_map(|t| t.x).chain(first.term.x).collect();
        let ends = [f64::min, f64::max].map(|pick| xs.iter().copied().reduce(pick));
        families.push(Family {
            // Chance is asked of the best term, wherever it is.
            first: Asked { probability: asked(&found[k]).probability, ..asked(first) },
            beyond: (beyond, probability(most)),
            also: Vec::new(),
            like: members.iter().map(|&j| found[j].term.words()).collect(),
            between: ends[0].zip(ends[1]).map(|(low, high)| [low, high]),
        });
    }
    let mut best: Vec<Asked> = Vec::new();
    for f in &found {
        // The most gain comes first.
        if !best.iter().any(|a| a.effect == f.term.effect && a.place == f.term.place) {
            best.push(asked(f));
        }
    }
    let by_chance = chance.get(chance.len() * 19 / 20).copied().filter(|g| g.is_finite())?;
    let of_a_law = |f: &&Found| f.term.of_a_law && f.term.times.is_empty();
    let far = |f: &&Found| f.told.strength.abs() > FAR * f.told.sd;
    let laws = found.iter().filter(of_a_law).filter(far).map(asked).collect();
    Some(Missing { tried: found.len(), by_chance, families, best, laws })
}

/// Standard deviations from none from which on the gain or the delay of a law is far from it: of the few laws
/// of a model one is there by chance in some thousand.
const FAR: f64 = 4.0;

/// A term that the data say something of.
struct Found {
    term: Term,
    direction: Vec<f64>,
    told: Told,
}

/// What is left of every term when some are in the model: scores and directions made orthogonal to those, by
/// the inverse covariance of the data.
struct Left {
    observations: usize,
    /// Scores in their standard deviations.
    scores: Vec<f64>,
    /// Share of the information that the terms taken leave.
    shares: Vec<f64>,
    /// Share of it that the parameters leave.
    free: Vec<f64>,
    taken: Vec<bool>,
    /// The directions taken, P times and of length one.
    inside: Vec<Vec<f64>>,
}

impl Left {
    fn of(found: &[Found], observations: usize) -> Self {
        Self {
            observations,
            scores: found.iter().map(|f| f.told.strength / f.told.sd).collect(),
            shares: vec![1.0; found.len()],
            free: found.iter().map(|f| f.told.left).collect(),
            taken: vec![false; found.len()],
            inside: Vec::new(),
        }
    }

    /// The gain of a term beyond those taken, with the noise as fitted.
    fn gain(&self, k: usize) -> f64 {
        let drop = 0.5 * self.scores[k].powi(2) / self.shares[k];
        gain(drop, self.free[k] * self.shares[k] * self.observations as f64)
    }

    /// The term of the largest gain beyond those taken, and that gain.
    fn best(&self) -> Option<(usize, f64)> {
        let open = (0..self.taken.len()).filter(|&k| !self.taken[k] && self.shares[k] > OWN);
        open.map(|k| (k, self.gain(k))).max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Of terms that the data hardly tell apart, the most probable one of the most probable effect at a
    /// place. The best of hundreds is where noise put it, and what acts at a place has two phases and may
    /// depend on several factors: an effect is judged by all that its terms gain together.
    fn most_probable(&self, found: &[Found], all: &[usize], expected: &[f64]) -> Option<usize> {
        let ln = |j: usize| self.gain(j) + expected[j];
        let mut best: BTreeMap<[&str; 2], usize> = BTreeMap::new();
        for &j in all.iter().filter(|j| self.shares[**j] > OWN) {
            let there = best.entry(found[j].term.whole()).or_insert(j);
            if ln(j) > ln(*there) {
                *there = j;
            }
        }
        let whole = |k: usize| ln(k) + self.further(found, k);
        best.into_values().map(|k| (k, whole(k))).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(k, _)| k)
    }

    /// What further terms of the effect of a term gain beside it, one after the other; each pays for being
    /// the best of its effect.
    fn further(&self, found: &[Found], k: usize) -> f64 {
        let there = |j: &usize| found[*j].term.whole() == found[k].term.whole() && !self.taken[*j];
        let there: Vec<usize> = (0..found.len()).filter(there).collect();
        let mut rest = Self {
            observations: self.observations,
            scores: there.iter().map(|&j| self.scores[j]).collect(),
            shares: there.iter().map(|&j| self.shares[j]).collect(),
            free: there.iter().map(|&j| self.free[j]).collect(),
            taken: vec![false; there.len()],
            inside: self.inside.clone(),
        };
        let terms: Vec<&Found> = there.iter().map(|&j| &found[j]).collect();
        let price = (there.len() as f64).ln();
        let (mut next, mut sum) = (there.iter().position(|&j| j == k), 0.0);
        for _ in 1..OF_AN_EFFECT {
            let Some(own) = next else { break };
            rest.take(&terms, own, &[]);
            let gained = rest.best().map(|(j, gain)| (j, gain - price)).filter(|(_, gain)| *gain > 0.0);
            sum += gained.map_or(0.0, |(_, gain)| gain);
            next = gained.map(|(j, _)| j);
        }
        sum
    }

    fn take<F: Borrow<Found>>(&mut self, found: &[F], k: usize, members: &[usize]) {
        members.iter().chain([&k]).for_each(|&j| self.taken[j] = true);
        let own: &Found = found[k].borrow();
        let mut pulled: Vec<f64> = own.told.pulled.iter().map(|p| p * own.told.sd).collect();
        for other in &self.inside {
            let along = dot(&own.direction, other) * own.told.sd;
            pulled.iter_mut().zip(other).for_each(|(p, o)| *p -= along * o);
        }
        let length = self.shares[k].sqrt();
        pulled.iter_mut().for_each(|p| *p /= length);
        let score = self.scores[k] / length;
        for (j, f) in found.iter().map(|f| -> &Found { f.borrow() }).enumerate() {
            let along = dot(&f.direction, &pulled) * f.told.sd;
            self.scores[j] -= along * score;
            self.shares[j] -= along * along;
        }
        self.inside.push(pulled);
    }
}

/// ln prior of every term before the data: what is missing sits as soon at a thing that is in the rig, at an
/// end or along all ducts, as anywhere on the grid, and is as soon the same at all points as in proportion to
/// something. Within these halves places and factors are alike.
fn expected(found: &[Found]) -> Vec<f64> {
    let places = |named: bool| {
        let all = found.iter().filter(|f| f.term.named == named).map(|f| &f.term.place);
        all.collect::<BTreeSet<_>>().len().max(1) as f64
    };
    let times = found.iter().map(|f| &f.term.times).filter(|t| !t.is_empty());
    let (times, places) = (times.collect::<BTreeSet<_>>().len().max(1) as f64, [places(false), places(true)]);
    let of = |f: &Found| {
        let by = if f.term.times.is_empty() { 1.0 } else { times };
        -(by * places[usize::from(f.term.named)]).ln()
    };
    found.iter().map(of).collect()
}

/// Share of a direction below which it is one of those taken.
const OWN: f64 = 1e-3;

/// The largest gain of all terms in data drawn by the model itself, ascending; noise that floats is estimated
/// anew for each.
fn by_chance(linear: &Linearised, found: &[Found], observations: usize) -> Vec<f64> {
    let streams = Streams::new(u64::from_le_bytes(*b"missing\0"));
    let draws: Vec<_> = (0..DRAWS)
        .into_par_iter()
        .map(|k| linear.draw(&mut streams.stream(&format!("engine/missing/{k}"))))
        .collect();
    let data = linear.pulls().len();
    let pulls = Matrix::from_fn(data, draws.len(), |i, k| draws[k].pulls[i]);
    let best = |chunk: &[Found]| {
        let unit = Matrix::from_fn(chunk.len(), data, |t, i| chunk[t].direction[i] * chunk[t].told.sd);
        let scores = unit.large_product(&pulls);
        let mut best = vec![f64::NEG_INFINITY; draws.len()];
        for (t, Found { told, .. }) in chunk.iter().enumerate() {
            for (k, draw) in draws.iter().enumerate() {
                let shares = told.shares.iter().zip(&draw.noise);
                let variance = 1.0 + shares.map(|(share, noise)| share * (noise - 1.0)).sum::<f64>();
                let drop = 0.5 * scores[(t, k)].powi(2) / variance.max(f64::EPSILON);
                best[k] = f64::max(best[k], told.gain(drop, observations));
            }
        }
        best
    };
    let larger = |a: Vec<f64>, b: Vec<f64>| a.iter().zip(&b).map(|(a, b)| a.max(*b)).collect();
    let none = || vec![f64::NEG_INFINITY; draws.len()];
    let mut all = found.par_chunks(CHUNK).map(best).reduce(none, larger);
    all.sort_by(f64::total_cmp);
    all
}

/// Terms that are scored at once.
const CHUNK: usize = 128;

impl Term {
    /// The effect that it is a part of: what acts, and where.
    fn whole(&self) -> [&str; 2] {
        [&self.place, &self.acts]
    }

    fn words(&self) -> String {
        words(&self.effect, &self.place, &self.times)
    }
}

#[cfg(test)]
mod tests {
    use super::Left;

    /// The largest score belongs to a term that was taken, the next to one that those taken make up.
    #[test]
    fn exact_the_best_term_is_neither_taken_nor_made_of_those_taken() {
        let left = Left {
            observations: 10,
            scores: vec![5.0, 0.3, 2.0, 1.0],
            shares: vec![0.5, 1e-6, 1.0, 1.0],
            free: vec![1.0; 4],
            taken: vec![true, false, false, false],
            inside: Vec::new(),
        };
        let (best, gain) = left.best().unwrap();
        assert_eq!(best, 2);
        // ln of the Bayes factor of a normal prior of ten times the variance that the data leave.
        let exact = 0.5 * 4.0 * 10.0 / 11.0 - 0.5 * 11.0_f64.ln();
        assert!((gain - exact).abs() < 1e-12, "{gain} {exact}");
    }
}
