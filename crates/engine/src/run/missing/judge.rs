//! Scores of all terms, families of those that are alike, and what chance would do.

use super::library::{Library, Term};
use crate::run::found::{Asked, Family, Missing, words};
use rayon::prelude::*;
use rijke_inference::{Linearised, Told, gain};
use rijke_numerics::{Matrix, Streams, dot};

/// Directions of a larger correlation belong to one family.
const ALIKE: f64 = 0.9;

/// Families that are told.
const TOLD: usize = 6;

/// Data sets that are drawn.
const DRAWS: usize = 1000;

/// A term that the data say something of.
struct Found {
    term: Term,
    direction: Vec<f64>,
    told: Told,
}

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
            unit: term.unit.to_owned(),
            prior_sd: told.prior_sd(observations),
            gain: told.gain(told.drop[1], observations),
            probability: probability(told.gain(told.drop[0], observations)),
            moves: [rms(0), rms(1)],
        }
    };
    let mut families: Vec<Family> = Vec::new();
    let mut left = Left::of(&found, observations);
    while let Some((k, beyond)) = left.best().filter(|_| families.len() < TOLD) {
        let first = &found[k];
        let alike = |j: &usize| {
            let product = dot(&found[*j].direction, &first.told.pulled);
            (product * first.told.sd * found[*j].told.sd).abs() > ALIKE
        };
        let members: Vec<usize> =
            (0..found.len()).filter(|j| *j != k && !left.taken[*j]).filter(alike).collect();
        let xs = members.iter().map(|&j| &found[j].term).filter(|t| t.effect == first.term.effect);
        let xs: Vec<f64> = xs.filter_map(|t| t.x).chain(first.term.x).collect();
        let ends = [f64::min, f64::max].map(|pick| xs.iter().copied().reduce(pick));
        families.push(Family {
            first: asked(first),
            beyond: (beyond, probability(beyond)),
            like: members.iter().map(|&j| found[j].term.words()).collect(),
            between: ends[0].zip(ends[1]).map(|(low, high)| [low, high]),
        });
        left.take(&found, k, &members);
    }
    let mut best: Vec<Asked> = Vec::new();
    for f in &found {
        // The most gain comes first.
        if !best.iter().any(|a| a.effect == f.term.effect && a.place == f.term.place) {
            best.push(asked(f));
        }
    }
    let by_chance = chance.get(chance.len() * 19 / 20).copied().filter(|g| g.is_finite())?;
    Some(Missing { tried: found.len(), by_chance, families, best })
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

    /// The term of the largest gain beyond those taken, and that gain with the noise as fitted.
    fn best(&self) -> Option<(usize, f64)> {
        let gain = |k: usize| {
            let drop = 0.5 * self.scores[k].powi(2) / self.shares[k];
            gain(drop, self.free[k] * self.shares[k] * self.observations as f64)
        };
        let open = (0..self.taken.len()).filter(|&k| !self.taken[k] && self.shares[k] > OWN);
        open.map(|k| (k, gain(k))).max_by(|a, b| a.1.total_cmp(&b.1))
    }

    fn take(&mut self, found: &[Found], k: usize, members: &[usize]) {
        members.iter().chain([&k]).for_each(|&j| self.taken[j] = true);
        let own = &found[k];
        let mut pulled: Vec<f64> = own.told.pulled.iter().map(|p| p * own.told.sd).collect();
        for other in &self.inside {
            let along = dot(&own.direction, other) * own.told.sd;
            pulled.iter_mut().zip(other).for_each(|(p, o)| *p -= along * o);
        }
        let length = self.shares[k].sqrt();
        pulled.iter_mut().for_each(|p| *p /= length);
        let score = self.scores[k] / length;
        for (j, f) in found.iter().enumerate() {
            let along = dot(&f.direction, &pulled) * f.told.sd;
            self.scores[j] -= along * score;
            self.shares[j] -= along * along;
        }
        self.inside.push(pulled);
    }
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
    fn words(&self) -> String {
        words(&self.effect, &self.place, &self.times)
    }
}
