//! Flames that answer to a velocity elsewhere.

use super::cuts::Piece;
use super::fill::Filled;
use super::model::PointModel;
use crate::EngineError;
use crate::conditions::Conditions;
use rijke_network::laws::NoReference;
use rijke_network::{At, Coefficients, Laws, NetworkError, Pole, Region, Slot, zeros_of};
use rijke_numerics::C64;
use rijke_study::names::{AREA, TEMPERATURE};
use std::f64::consts::PI;

impl PointModel<'_> {
    /// Attaches the flames that answer to a velocity elsewhere: their laws are T of -k_eu, and k_eu and k_ep
    /// follow.
    pub(super) fn listen(&mut self, conditions: &Conditions, pieces: &[Piece]) -> Result<(), EngineError> {
        let mut sources = Vec::new();
        for k in 0..self.laws.len() {
            let effect = self.effect(&self.laws[k]);
            let (Some(hears), place) = (effect.hears, effect.place.clone()) else { continue };
            let name = effect.place_text.clone();
            // One law for every place of the part, in their order.
            let before = sources.iter().filter(|(_, _, _, other)| *other == name).count();
            let Some((x, _)) = conditions.layout.places(&place).get(before).copied() else { continue };
            sources.push((k, x, hears, name));
        }
        let first = self.laws.len();
        let fail = |source| EngineError::Network { point: conditions.id.clone(), source };
        for (h, (_, x, ..)) in sources.iter().enumerate() {
            let j = self.network.place_at(*x).map_err(fail)?;
            self.network.attach(Slot::Eu(j), first + 2 * h, 1.0).map_err(fail)?;
            self.network.attach(Slot::Ep(j), first + 2 * h + 1, 1.0).map_err(fail)?;
        }
        for (h, (k, x, hears, part)) in sources.into_iter().enumerate() {
            let wrong = |problem: String| EngineError::Reference {
                point: conditions.id.clone(),
                part: part.clone(),
                problem,
            };
            if self.assembly.mean_flow().is_some() {
                let problem = "and a candidate asks for waves in the mean flow: here the gas must be at rest";
                return Err(wrong(problem.into()));
            }
            let (j, own) = (self.network.place_at(x).map_err(fail)?, [first + 2 * h, first + 2 * h + 1]);
            let distance = conditions.layout.numbers[hears.distance];
            if distance.is_nan() || distance < 0.0 {
                return Err(wrong(format!("whose distance is {distance} m there: give zero or more")));
            }
            let heard = self.network.remote_source(j, distance, hears.downstream, k, own);
            let mut heard = heard.map_err(|why: NoReference| wrong(why.to_string()))?;
            heard.factor = -1.0;
            if hears.of_mean {
                // Q'/Q = n F u'/U: as much mass flows through the reference.
                let around = &self.surroundings[self.laws[k].around];
                let behind = hears.downstream.then_some(j.min(pieces.len() - 1));
                if let Some(i) = heard.segment().or(behind) {
                    let (gas, area) = (&pieces[i].gas, pieces[i].segment.area);
                    heard.factor *= around[TEMPERATURE] / gas.temperature * area / around[AREA];
                }
            }
            self.heard.push(heard);
        }
        Ok(())
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
            let size = (region.sigma[1] - region.sigma[0]) + (region.omega[1] - region.omega[0]);
            let step = (0.25 * PI / heard.travel_time().max(1e-9)).min(size / SAMPLES);
            let zeros = zeros_of(open_loop, region, step, poles)?;
            all.extend(zeros.into_iter().map(|(at, order)| Pole { law: first + 2 * h, at, order }));
        }
        Ok(())
    }
}

/// Samples round a region at least, as for other laws.
const SAMPLES: f64 = 400.0;
