//! The network, and which of its numbers are laws.

use crate::assembly::part_of_wall;
use crate::{Assembly, Conditions, EngineError};
use rijke_network::{Network, NetworkError, Segment, Slot};
use rijke_numerics::{JetSpace, Order};
use rijke_study::{Coefficient, DuctAt, Effect, PartAt, Place, Shape, Value};

/// A network for one operating point in gas at rest, of one temperature in every duct.
#[derive(Clone, Debug)]
pub struct ShapeModel<'a> {
    pub(crate) assembly: &'a Assembly,
    pub(crate) network: Network,
    /// What the network's laws are, by their numbers.
    pub(crate) laws: Vec<LawOf>,
    /// Where segments begin and end, ascending.
    pub(crate) cuts: Vec<At>,
    /// The parts that are ducts, from upstream to downstream.
    pub(crate) ducts: Vec<usize>,
    /// The duct of every segment.
    pub(crate) duct_of: Vec<usize>,
    /// Names that are the same everywhere.
    pub(crate) numbers: Vec<f64>,
    /// Temperature of every duct, K, if it is known.
    pub(crate) temperatures: Vec<f64>,
    /// Mean pressure, Pa.
    pub(crate) pressure: f64,
    /// Mass flow through the ducts, kg/s.
    pub(crate) mass_flow: f64,
    /// About how far modes lie from each other, rad/s.
    pub(crate) spacing: f64,
    /// What laws see, by duct of the upstream side and that of the downstream side.
    pub(crate) surroundings: Vec<([usize; 2], Vec<f64>)>,
    /// Place in the network of every instrument.
    pub(crate) microphones: Vec<usize>,
}

/// Where a cut is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum At {
    /// Behind so many ducts.
    Boundary(usize),
    /// Place number `.1` of a part.
    Part(usize, usize),
    /// At this microphone.
    Microphone(usize),
    /// At a known place, m.
    Fixed(f64),
}

/// A law of the network.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LawOf {
    /// An effect of a candidate, in surroundings of this number.
    Effect { candidate: usize, effect: usize, around: usize },
    /// What the length of a segment has beyond the one in the network, m.
    Length(usize),
    /// The same of its area, m^2.
    Area(usize),
    /// The same of its speed of sound, m/s.
    SoundSpeed(usize),
    /// The same of its density, kg/m^3.
    Density(usize),
}

/// Places closer than this part of the length are the same.
const SAME: f64 = 1e-9;

impl<'a> ShapeModel<'a> {
    /// Lays out the network, at the medians of the unknowns; its laws move it. `instruments` are the places
    /// that are heard, m.
    ///
    /// # Errors
    /// [`EngineError::Shape`] for gas that varies along a duct, cones, a mean flow, laws along a part of a
    /// duct; [`EngineError::Network`].
    pub fn new(
        assembly: &'a Assembly,
        conditions: &Conditions,
        instruments: &[f64],
    ) -> Result<Self, EngineError> {
        let refuse = |problem| Err(EngineError::Shape { point: conditions.id.clone(), problem });
        if let Some(problem) = not_modelled(assembly, conditions) {
            return refuse(problem);
        }
        let (layout, base) = (&conditions.layout, &conditions.base);
        let cuts = cuts(assembly, conditions, instruments);
        let xs: Vec<f64> = cuts.iter().map(|c| c.0).collect();
        let duct_of: Vec<usize> = xs
            .windows(2)
            .map(|w| {
                let middle = 0.5 * (w[0] + w[1]);
                layout.ducts.iter().position(|d| middle < d.span[1]).unwrap_or(layout.ducts.len() - 1)
            })
            .collect();
        let segment = |(w, duct): (&[f64], &usize)| {
            let from = layout.ducts[*duct].span[0];
            let gas = base.gas_beside(from, 1).at(base.temperatures(from)[1], base.pressure);
            Segment::new(w[1] - w[0], layout.ducts[*duct].area[0], gas.sound_speed, gas.density)
        };
        let fail = |source| EngineError::Network { point: conditions.id.clone(), source };
        let network = Network::new(xs.windows(2).zip(&duct_of).map(segment).collect()).map_err(fail)?;
        let nearest = |x: f64| xs.iter().position(|c| (c - x).abs() <= SAME * layout.length).unwrap_or(0);
        let mut model = Self {
            assembly,
            network,
            laws: Vec::new(),
            cuts: cuts.iter().map(|c| c.1).collect(),
            ducts: layout.ducts.iter().map(|d| d.part).collect(),
            duct_of,
            numbers: layout.numbers.clone(),
            temperatures: layout.ducts.iter().map(|d| base.temperatures(d.span[0])[1]).collect(),
            pressure: base.pressure,
            mass_flow: base.mass_flow,
            spacing: std::f64::consts::PI / base.travel_time(0.0, layout.length),
            surroundings: Vec::new(),
            microphones: instruments.iter().map(|x| nearest(*x)).collect(),
        };
        for (k, candidate) in assembly.candidates().iter().enumerate() {
            for (e, effect) in candidate.effects.iter().enumerate() {
                if effect.hears.is_some() {
                    let (part, problem) =
                        (effect.place_text.clone(), "and here it must answer to that where it is");
                    let point = conditions.id.clone();
                    return Err(EngineError::Reference { point, part, problem: problem.into() });
                }
                if !model.attach(conditions, k, e, effect, &nearest).map_err(fail)? {
                    return refuse(
                        "a law acts along a stretch or on mp or eu along a duct: only losses of walls may",
                    );
                }
            }
        }
        if assembly.rig.is_of_unknown_shape() {
            model.attach_shape().map_err(fail)?;
        }
        Ok(model)
    }

    /// The effect called `effect` of a candidate.
    pub(crate) fn effect(&self, candidate: usize, effect: usize) -> &Effect {
        &self.assembly.candidates()[candidate].effects[effect]
    }

    /// The space of jets of the free parameters and s.
    pub(crate) fn space(&self, order: Order) -> JetSpace {
        JetSpace::new(self.assembly.parameters().len() + 1, order)
    }

    /// Attaches what lengths and areas, and properties of unknown gas, have beyond those of the network.
    fn attach_shape(&mut self) -> Result<(), NetworkError> {
        for i in 0..self.duct_of.len() {
            let shape = [(Slot::Length(i), LawOf::Length(i)), (Slot::Area(i), LawOf::Area(i))];
            let gas = [(Slot::SoundSpeed(i), LawOf::SoundSpeed(i)), (Slot::Density(i), LawOf::Density(i))];
            let of_unknown_gas = self.assembly.rig.parts[self.ducts[self.duct_of[i]]].is_of_unknown_gas();
            for (slot, law) in shape.into_iter().chain(gas.into_iter().filter(|_| of_unknown_gas)) {
                self.laws.push(law);
                self.network.attach(slot, self.laws.len() - 1, 1.0)?;
            }
        }
        Ok(())
    }

    /// Puts an effect where it acts; false if it acts in a way that is not modelled.
    fn attach(
        &mut self,
        conditions: &Conditions,
        candidate: usize,
        number: usize,
        effect: &Effect,
        place_at: &dyn Fn(f64) -> usize,
    ) -> Result<bool, NetworkError> {
        let last = self.duct_of.len();
        if let Place::Duct(which) = effect.place {
            let wave = effect.coefficient.is_wave();
            if part_of_wall(effect).is_none() && !wave {
                return Ok(false);
            }
            for duct in 0..self.ducts.len() {
                if which.is_some_and(|part| self.ducts[duct] != part) {
                    continue;
                }
                let [from, to] = conditions.layout.ducts[duct].span;
                let around = self.around(conditions, [duct, duct], 0.5 * (from + to));
                let law = self.law(candidate, number, around);
                if wave {
                    continue;
                }
                for i in (0..last).filter(|i| self.duct_of[*i] == duct).collect::<Vec<_>>() {
                    let slot = if effect.coefficient == Coefficient::Mu {
                        Slot::Viscous(i)
                    } else {
                        Slot::Thermal(i)
                    };
                    self.network.attach(slot, law, 1.0)?;
                }
            }
            return Ok(true);
        }
        if effect.place.is_along() {
            return Ok(conditions.layout.stretches(&effect.place).is_empty());
        }
        for (x, share) in conditions.layout.places(&effect.place) {
            let j = place_at(x);
            let beside = [j.saturating_sub(1), j.min(last - 1)].map(|i| self.duct_of[i]);
            let around = self.around(conditions, beside, x);
            let law = self.law(candidate, number, around);
            let slot = match (effect.coefficient, effect.place.is_end()) {
                (_, true) if j == 0 => Slot::Upstream,
                (_, true) => Slot::Downstream,
                (Coefficient::Mp, _) => Slot::Mp(j),
                (Coefficient::Eu, _) => Slot::Eu(j),
                (Coefficient::Ep, _) => Slot::Ep(j),
                _ => Slot::Mu(j),
            };
            self.network.attach(slot, law, share)?;
        }
        Ok(true)
    }

    fn law(&mut self, candidate: usize, effect: usize, around: usize) -> usize {
        let law = LawOf::Effect { candidate, effect, around };
        let known = self.laws.iter().position(|other| *other == law);
        known.unwrap_or_else(|| {
            self.laws.push(law);
            self.laws.len() - 1
        })
    }

    /// The surroundings at `x`, between or within these ducts.
    fn around(&mut self, conditions: &Conditions, ducts: [usize; 2], x: f64) -> usize {
        let numbers = conditions.around(x);
        let same = |other: &([usize; 2], Vec<f64>)| {
            other.0 == ducts && other.1.iter().zip(&numbers).all(|(a, b)| a.to_bits() == b.to_bits())
        };
        if let Some(known) = self.surroundings.iter().position(same) {
            return known;
        }
        self.surroundings.push((ducts, numbers));
        self.surroundings.len() - 1
    }
}

/// What no network of unknown shape has, if a point has it.
fn not_modelled(assembly: &Assembly, conditions: &Conditions) -> Option<&'static str> {
    let layout = &conditions.layout;
    let base = &conditions.base;
    let of_one_gas = |[from, to]: [f64; 2]| {
        let first = base.temperatures(from)[1];
        let inside = base.places.iter().filter(|x| (from..to).contains(*x) && **x > from);
        base.temperatures(to)[0] == first && inside.into_iter().all(|x| base.temperatures(*x) == [first; 2])
    };
    if !layout.ducts.iter().all(|d| of_one_gas(d.span)) {
        return Some("the temperature varies along a duct: cut it into ducts of one temperature each");
    }
    if assembly.mean_flow().is_some() {
        return Some("a candidate requires waves in the mean flow: the gas must be at rest");
    }
    let graded = |d: &DuctAt| d.temperatures.len() > 1 && assembly.rig.parts[d.part].is_of_unknown_gas();
    if layout.ducts.iter().any(graded) {
        return Some("an unknown temperature varies along a duct: give it one `temperature`");
    }
    if layout.ducts.iter().any(|d| d.area[0] != d.area[1]) {
        return Some(
            "a duct changes its area along itself: write the cone as straight ducts, 40 say, each with the diameter of its middle, and at both ends of \
             the cone one of 1e-6 m with the diameter there, because the law of an end takes the radius of the duct beside it",
        );
    }
    None
}

/// Where segments begin and end, m, ascending; `instruments` are the places that are heard, m.
fn cuts(assembly: &Assembly, conditions: &Conditions, instruments: &[f64]) -> Vec<(f64, At)> {
    let (rig, layout) = (&assembly.rig, &conditions.layout);
    let mut cuts: Vec<(f64, At)> = vec![(0.0, At::Boundary(0))];
    cuts.extend(layout.ducts.iter().enumerate().map(|(k, d)| (d.span[1], At::Boundary(k + 1))));
    for (k, (part, at)) in rig.parts.iter().zip(&layout.parts).enumerate() {
        if let (Shape::Device(list), PartAt::Places(places)) = (&part.shape, at) {
            let of = |(i, x): (usize, &f64)| (*x, At::Part(k, i));
            cuts.extend(places.iter().enumerate().take(list.len()).map(of));
        }
    }
    let instrument = |x: &f64| {
        let moves = |(at, known): (&Value, &f64)| known == x && at.unknown().is_some();
        let all = || rig.microphones.at.iter().zip(&layout.microphones);
        (*x, all().position(moves).map_or(At::Fixed(*x), At::Microphone))
    };
    cuts.extend(instruments.iter().map(instrument));
    // Of places that are the same the boundary of a duct stays, because it comes first.
    cuts.sort_by(|a, b| a.0.total_cmp(&b.0));
    cuts.dedup_by(|later, first| (later.0 - first.0).abs() <= SAME * layout.length);
    cuts
}
