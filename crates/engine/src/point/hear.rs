//! Flames that answer to a velocity elsewhere.

use super::cuts::Piece;
use super::model::PointModel;
use super::spread::SpreadAt;
use crate::EngineError;
use crate::conditions::Conditions;
use rijke_network::laws::{HeardLaws, NoReference, RemoteSource, SpreadPiece, spread_weights};
use rijke_study::names::{AREA, DENSITY};
use rijke_study::{Hears, Spread};

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
        let (spread, compact): (Vec<Source>, Vec<Source>) =
            sources.into_iter().partition(|s| s.hears.spread.is_some());
        let places = |all: &[Source]| -> Result<Vec<usize>, EngineError> {
            all.iter().map(|source| self.network.place_at(source.x).map_err(fail)).collect()
        };
        let places = [places(&compact)?, places(&spread)?];
        let first = self.laws.len();
        let HeardLaws { of_compact, of_spread } =
            self.network.attach_heard(first, &places[0], &places[1]).map_err(fail)?;
        for (source, own) in compact.iter().zip(&of_compact) {
            let (j, distance) = self.reference_of(conditions, source)?;
            let heard = self.network.remote_source(j, distance, source.hears.downstream, source.law, own);
            let mut heard = heard.map_err(|why: NoReference| source.wrong(conditions, why.to_string()))?;
            self.weigh(&mut heard, source, pieces, j);
            self.heard.sources.push(heard);
        }
        for (source, own) in spread.iter().zip(&of_spread) {
            let (j, distance) = self.reference_of(conditions, source)?;
            let Some(spread) = &source.hears.spread else { continue };
            let (end, released) = self.released(conditions, source, spread)?;
            let heard = self.network.remote_spread([j, end], &released, distance, own);
            let mut heard = heard.map_err(|why: NoReference| source.wrong(conditions, why.to_string()))?;
            self.weigh(&mut heard.source, source, pieces, j);
            self.heard.spreads.push(heard);
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
