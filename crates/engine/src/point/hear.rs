//! Flames that answer to a velocity elsewhere.

use super::cuts::Piece;
use super::fill::Filled;
use super::model::PointModel;
use super::poles::SAMPLES;
use super::spread::SpreadAt;
use crate::EngineError;
use crate::conditions::Conditions;
use rijke_network::laws::{NoReference, RemoteSource, SpreadPiece, spread_weights};
use rijke_network::{At, Coefficients, Laws, NetworkError, Pole, Region, Slot, zeros_of};
use rijke_numerics::C64;
use rijke_study::names::{AREA, DENSITY};
use rijke_study::{Hears, Spread};
use std::f64::consts::PI;

/// A flame that answers to a velocity elsewhere.
pub(super) struct Source {
    /// Number of the law that is T; those of further pieces follow.
    pub(super) law: usize,
    /// Where it is, m.
    pub(super) x: f64,
    /// What it answers to.
    pub(super) hears: Hears,
    /// Its name in the file.
    pub(super) part: String,
}

impl PointModel<'_> {
    /// Attaches the flames that answer to a velocity elsewhere: their laws are T of -k_eu, and their
    /// coefficients follow.
    pub(super) fn listen(
        &mut self,
        conditions: &Conditions,
        pieces: &[Piece],
        sources: Vec<Source>,
    ) -> Result<(), EngineError> {
        let fail = |source| EngineError::Network { point: conditions.id.clone(), source };
        // Those that are compact have two laws of their own, then those that are spread have four.
        let (spread, compact): (Vec<Source>, Vec<Source>) =
            sources.into_iter().partition(|s| s.hears.spread.is_some());
        let first = self.laws.len();
        let first_spread = first + 2 * compact.len();
        for (h, source) in compact.iter().enumerate() {
            let j = self.network.place_at(source.x).map_err(fail)?;
            for (k, slot) in [Slot::Eu(j), Slot::Ep(j)].into_iter().enumerate() {
                self.network.attach(slot, first + 2 * h + k, 1.0).map_err(fail)?;
            }
        }
        for (h, source) in spread.iter().enumerate() {
            let j = self.network.place_at(source.x).map_err(fail)?;
            for (k, slot) in [Slot::Eu(j), Slot::Mu(j), Slot::Ep(j), Slot::Mp(j)].into_iter().enumerate() {
                self.network.attach(slot, first_spread + 4 * h + k, 1.0).map_err(fail)?;
            }
        }
        for (h, source) in compact.iter().enumerate() {
            let (j, distance) = self.reference_of(conditions, source)?;
            let own = [0, 1].map(|k| first + 2 * h + k);
            let heard = self.network.remote_source(j, distance, source.hears.downstream, source.law, &own);
            let mut heard = heard.map_err(|why: NoReference| source.wrong(conditions, why.to_string()))?;
            self.weigh(&mut heard, source, pieces, j);
            self.heard.push(heard);
        }
        for (h, source) in spread.iter().enumerate() {
            let (j, distance) = self.reference_of(conditions, source)?;
            let Some(spread) = &source.hears.spread else { continue };
            let own = [0, 1, 2, 3].map(|k| first_spread + 4 * h + k);
            let (end, released) = self.released(conditions, source, spread)?;
            let heard = self.network.remote_spread([j, end], &released, distance, own);
            let mut heard = heard.map_err(|why: NoReference| source.wrong(conditions, why.to_string()))?;
            self.weigh(&mut heard.source, source, pieces, j);
            self.spread.push(heard);
        }
        Ok(())
    }

    /// The place of a source in the network, and how far away its reference is, m.
    fn reference_of(&self, conditions: &Conditions, source: &Source) -> Result<(usize, f64), EngineError> {
        if self.assembly.mean_flow().is_some() {
            let problem = "and a candidate requires waves in the mean flow: here the gas must be at rest";
            return Err(source.wrong(conditions, problem.into()));
        }
        let j = self.network.place_at(source.x);
        let j = j.map_err(|source| EngineError::Network { point: conditions.id.clone(), source })?;
        let distance = conditions.layout.numbers[source.hears.distance];
        if distance.is_nan() || distance < 0.0 {
            let problem = format!("whose distance is {distance} m there: give zero or more");
            return Err(source.wrong(conditions, problem));
        }
        Ok((j, distance))
    }

    /// Where a spread flame ends in the network, and its pieces.
    fn released(
        &self,
        conditions: &Conditions,
        source: &Source,
        spread: &Spread,
    ) -> Result<(usize, Vec<SpreadPiece>), EngineError> {
        let fail = |source| EngineError::Network { point: conditions.id.clone(), source };
        let flame = SpreadAt::new(spread, source.x, &conditions.layout);
        let total = conditions.layout.length;
        if !(flame.end() > source.x && flame.end() <= total * (1.0 + 1e-9)) {
            let end = flame.end();
            let problem = format!(
                "and its heat ends at {end} m: give a `length` that ends on the ducts, which are {total} m long"
            );
            return Err(source.wrong(conditions, problem));
        }
        let weights = spread_weights(&spread.density, spread.pieces).ok_or_else(|| {
            source.wrong(
                conditions,
                "and its density is 0 in the middle of every piece: give more pieces".into(),
            )
        })?;
        let places = flame.middles().map(|x| self.network.place_at(x)).collect::<Result<Vec<_>, _>>();
        let laws = (source.law..).zip(weights);
        let piece = |(place, (law, weight))| SpreadPiece { place, law, weight };
        let all = places.map_err(fail)?.into_iter().zip(laws).map(piece);
        Ok((self.network.place_at(flame.end().min(total)).map_err(fail)?, all.collect()))
    }

    /// The factor that T has: its sign and, per heat of the mean flow, what is there.
    fn weigh(&self, heard: &mut RemoteSource, source: &Source, pieces: &[Piece], j: usize) {
        heard.factor = -1.0;
        if source.hears.of_mean {
            // Q'/Q = n F u'/U: as much mass flows through the reference.
            let around = &self.surroundings[self.laws[source.law].around];
            let behind = source.hears.downstream.then_some(j.min(pieces.len() - 1));
            if let Some(i) = heard.segment().or(behind) {
                let (gas, area) = (&pieces[i].gas, pieces[i].segment.area);
                heard.factor *= gas.density / around[DENSITY] * area / around[AREA];
            }
        }
    }
}

impl Source {
    fn wrong(&self, conditions: &Conditions, problem: String) -> EngineError {
        EngineError::Reference { point: conditions.id.clone(), part: self.part.clone(), problem }
    }
}

impl Filled<'_> {
    /// The laws of sources that answer to a velocity elsewhere, when all others are there.
    pub(super) fn fill_heard(&self, at: &At, laws: &mut Laws) {
        let first = self.model().laws.len();
        for (h, heard) in self.model().heard.iter().enumerate() {
            for (k, jet) in heard.coefficients(at, laws).iter().enumerate() {
                laws.set(first + 2 * h + k, jet);
            }
        }
        let first = first + 2 * self.model().heard.len();
        for (h, flame) in self.model().spread.iter().enumerate() {
            for (k, jet) in flame.coefficients(at, laws).iter().enumerate() {
                laws.set(first + 4 * h + k, jet);
            }
        }
    }

    /// The poles of those sources, in the place of the poles of T.
    pub(super) fn poles_of_heard(&self, all: &mut Vec<Pole>, region: &Region) -> Result<(), NetworkError> {
        let first = self.model().laws.len();
        for (h, heard) in self.model().heard.iter().enumerate() {
            let of_t = |p: &Pole| p.law == heard.law;
            let poles: Vec<(C64, usize)> = all.iter().filter(|p| of_t(p)).map(|p| (p.at, p.order)).collect();
            if heard.distance < 0.0 {
                all.iter_mut().filter(|p| of_t(p)).for_each(|p| p.law = first + 2 * h);
                continue;
            }
            // A loop has poles of its own, and none where T has.
            all.retain(|p| !of_t(p));
            let open_loop = |s: C64| {
                let at = At::search(s);
                let mut laws = Laws::default();
                laws.reset(self.laws(), &at);
                self.fill(&at, &mut laws);
                let jet = heard.open_loop(&at, &laws);
                jet.map_or([C64::ONE, C64::ZERO], |jet| [jet.value(), jet.gradient()[0]])
            };
            let step = (0.25 * PI / heard.travel_time().max(1e-9)).min(self.model().spacing / SAMPLES);
            let zeros = zeros_of(open_loop, region, step, poles)?;
            all.extend(zeros.into_iter().map(|(at, order)| Pole { law: first + 2 * h, at, order }));
        }
        let first = first + 2 * self.model().heard.len();
        for (h, flame) in self.model().spread.iter().enumerate() {
            let of_t = |p: &Pole| p.law == flame.source.law;
            all.iter_mut().filter(|p| of_t(p)).for_each(|p| p.law = first + 4 * h);
        }
        Ok(())
    }
}
