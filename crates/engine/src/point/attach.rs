//! Laws of effects, put where they act.

use super::cuts::Piece;
use super::hear::Source;
use super::model::{LawAt, PointModel};
use super::spread::SpreadAt;
use crate::assembly::part_of_wall;
use crate::conditions::Conditions;
use rijke_network::{NetworkError, Slot};
use rijke_study::names::{S, WALL_EP, WALL_MU};
use rijke_study::{Coefficient, Effect, Place};

impl PointModel<'_> {
    pub(super) fn effect(&self, law: &LawAt) -> &Effect {
        &self.assembly.candidates()[law.candidate].effects[law.effect]
    }

    /// Puts all laws where they act; the sources that answer to a velocity elsewhere are returned.
    pub(super) fn attach(
        &mut self,
        conditions: &Conditions,
        pieces: &[Piece],
    ) -> Result<Vec<Source>, NetworkError> {
        let mut sources = Vec::new();
        let layout = &conditions.layout;
        // One set of surroundings per distinct gas and area: in a cold uniform tube every segment shares it.
        let mut local: Vec<usize> = Vec::with_capacity(pieces.len());
        for (i, piece) in pieces.iter().enumerate() {
            let same =
                i > 0 && pieces[i - 1].gas == piece.gas && pieces[i - 1].segment.area == piece.segment.area;
            let around = if same {
                local[i - 1]
            } else {
                self.note(conditions.around_piece(&piece.gas, piece.segment.area))
            };
            local.push(around);
        }
        let assembly = self.assembly;
        let effects = assembly.candidates().iter().enumerate();
        let effects =
            effects.flat_map(|(k, c)| c.effects.iter().enumerate().map(move |(e, effect)| (k, e, effect)));
        for (candidate, number, effect) in effects {
            if effect.place.is_along() {
                for [from, to] in layout.stretches(&effect.place) {
                    self.along(candidate, number, effect.coefficient, pieces, &local, [from, to])?;
                }
                continue;
            }
            let mut shared = Shared::default();
            for (x, share) in layout.places(&effect.place) {
                if let Some(hears) = effect.hears.clone() {
                    // Attached when all else is, see `listen`.
                    let (law, part) = (self.laws.len(), effect.place_text.clone());
                    let around: Vec<Vec<f64>> = match &hears.spread {
                        None => vec![conditions.around(x)],
                        Some(spread) => SpreadAt::new(spread, x, layout).around(conditions).collect(),
                    };
                    for here in around {
                        let here = self.note(here);
                        self.law(candidate, number, here);
                    }
                    sources.push(Source { law, x, hears, part });
                    continue;
                }
                let here = self.note(conditions.around(x));
                if effect.place.is_end() {
                    let law = self.law(candidate, number, here);
                    let slot = if x > 0.0 { Slot::Downstream } else { Slot::Upstream };
                    self.network.attach(slot, law, share)?;
                } else {
                    let (law, weight) = self.shared(candidate, number, here, &mut shared);
                    let j = self.network.place_at(x)?;
                    self.network.attach(at_place(effect.coefficient, j), law, share * weight)?;
                }
            }
        }
        Ok(sources)
    }

    /// A law per metre over a stretch.
    fn along(
        &mut self,
        candidate: usize,
        effect: usize,
        coefficient: Coefficient,
        pieces: &[Piece],
        local: &[usize],
        [from, to]: [f64; 2],
    ) -> Result<(), NetworkError> {
        let mut shared = Shared::default();
        let mut before = None;
        let inside = |p: &Piece| (from..to).contains(&(0.5 * (p.from + p.to)));
        for (i, piece) in pieces.iter().enumerate().filter(|(_, p)| inside(p)) {
            // The halves of an element are of one gas.
            let (law, weight) = match before.filter(|(gas, _)| *gas == local[i]) {
                Some((_, found)) => found,
                None => self.shared(candidate, effect, local[i], &mut shared),
            };
            before = Some((local[i], (law, weight)));
            match coefficient {
                Coefficient::Mu => self.network.attach(Slot::Viscous(i), law, weight)?,
                Coefficient::Ep => self.network.attach(Slot::Thermal(i), law, weight)?,
                // Couplings that a line does not have, k_mp and k_eu per metre, act at both ends of each
                // segment, half at each.
                _ => {
                    for j in [i, i + 1] {
                        let half = 0.5 * weight * (piece.to - piece.from);
                        self.network.attach(at_place(coefficient, j), law, half)?;
                    }
                }
            }
        }
        Ok(())
    }

    fn note(&mut self, surroundings: Vec<f64>) -> usize {
        let same = |s: &Vec<f64>| s.iter().zip(&surroundings).all(|(a, b)| a.to_bits() == b.to_bits());
        match self.surroundings.iter().position(same) {
            Some(index) => index,
            None => {
                self.surroundings.push(surroundings);
                self.surroundings.len() - 1
            }
        }
    }

    fn law(&mut self, candidate: usize, effect: usize, around: usize) -> usize {
        self.laws.push(LawAt { candidate, effect, around });
        self.laws.len() - 1
    }

    /// The law of an effect in surroundings number `around`, and the weight with which it acts there.
    fn shared(
        &mut self,
        candidate: usize,
        effect: usize,
        around: usize,
        shared: &mut Shared,
    ) -> (usize, f64) {
        // A law that is not proportional to a number of one gas is so in none.
        let scale = if shared.own.is_empty() { self.scale(candidate, effect, around) } else { None };
        let scale = scale.filter(|g| g.is_finite() && *g != 0.0);
        if let Some(g) = scale {
            let (law, reference) = match shared.scaled {
                Some(known) => known,
                None => (self.law(candidate, effect, around), g),
            };
            shared.scaled = Some((law, reference));
            return (law, g / reference);
        }
        if let Some((_, law)) = shared.own.iter().find(|(other, _)| *other == around) {
            return (*law, 1.0);
        }
        let law = self.law(candidate, effect, around);
        shared.own.push((around, law));
        (law, 1.0)
    }

    /// The number of the local gas that the law of an effect is proportional to, if it is.
    fn scale(&self, candidate: usize, effect: usize, around: usize) -> Option<f64> {
        let (candidates, here) = (self.assembly.candidates(), &self.surroundings[around]);
        let law = &candidates[candidate].effects[effect].law;
        let mut analytic = [None; WALL_EP + 1];
        analytic[S] = Some(1.0);
        let bare = analytic;
        for (part, name) in [(0, WALL_MU), (1, WALL_EP)].into_iter().filter(|(_, name)| law.uses(*name)) {
            let mut along =
                candidates.iter().flat_map(|c| &c.effects).filter(|e| part_of_wall(e) == Some(part));
            // A sum of two walls has no common factor in general, and walls of one duct are none of another.
            let only = along.next().filter(|e| e.place == Place::Duct(None) || self.has_one_duct());
            analytic[name] = only.filter(|_| along.next().is_none()).and_then(|e| e.law.scale(here, &bare));
        }
        law.scale(here, &analytic)
    }

    /// Whether the law of an effect is a number of the local gas times something that is the same everywhere.
    pub(crate) fn is_proportional(&self, candidate: usize, effect: usize) -> bool {
        (0..self.surroundings.len()).any(|around| self.scale(candidate, effect, around).is_some())
    }

    fn has_one_duct(&self) -> bool {
        let ducts = self.assembly.rig.parts.iter().filter(|p| matches!(p.shape, rijke_study::Shape::Duct(_)));
        ducts.count() == 1
    }

    /// Keeps the surroundings in which a law is evaluated, and notes the laws of walls first.
    pub(super) fn forget_unused(&mut self) {
        let mut used: Vec<usize> = self.laws.iter().map(|law| law.around).collect();
        used.sort_unstable();
        used.dedup();
        for law in &mut self.laws {
            law.around = used.partition_point(|u| *u < law.around);
        }
        self.surroundings = used.iter().map(|&u| self.surroundings[u].clone()).collect();
        let is_wall = |k: &usize| part_of_wall(self.effect(&self.laws[*k])).is_some();
        let (walls, others): (Vec<usize>, Vec<usize>) = (0..self.laws.len()).partition(is_wall);
        self.order = [walls, others].concat();
    }

    /// Adds what the laws that name the wall's loss need of it, where no segment brings it.
    pub(super) fn complete_walls(&mut self) {
        let candidates = self.assembly.candidates();
        let mut missing = Vec::new();
        let uses_wall = |e: &Effect| e.law.uses(WALL_MU) || e.law.uses(WALL_EP);
        for law in self.laws.iter().filter(|l| uses_wall(self.effect(l))) {
            for (candidate, c) in candidates.iter().enumerate() {
                for effect in (0..c.effects.len()).filter(|&e| part_of_wall(&c.effects[e]).is_some()) {
                    let wall = LawAt { candidate, effect, around: law.around };
                    if !self.laws.contains(&wall) && !missing.contains(&wall) {
                        missing.push(wall);
                    }
                }
            }
        }
        self.laws.extend(missing);
    }
}

/// The laws of one effect at many places. Where the law is a number of the local gas times something that is
/// the same everywhere, all places share one law with a weight; elsewhere places of the same gas do.
#[derive(Default)]
struct Shared {
    /// The law, and its number at the place where it is evaluated.
    scaled: Option<(usize, f64)>,
    /// Surroundings and law.
    own: Vec<(usize, usize)>,
}

fn at_place(coefficient: Coefficient, j: usize) -> Slot {
    match coefficient {
        Coefficient::Mp => Slot::Mp(j),
        Coefficient::Eu => Slot::Eu(j),
        Coefficient::Ep => Slot::Ep(j),
        Coefficient::Mu | Coefficient::Reflection | Coefficient::Forward | Coefficient::Backward => {
            Slot::Mu(j)
        }
    }
}
