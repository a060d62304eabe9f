//! The model at one operating point.

use crate::elements;
use crate::fill::Filled;
use crate::{Assembly, Conditions, ModelError, Scheme};
use rijke_candidates::{Coefficient, Law, Place, Surroundings};
use rijke_flow::Stretch;
use rijke_network::{
    Network, NetworkError, Newton, Places, Response, Root, Segment, Slot, Workspace, levine_schwinger,
};
use rijke_numerics::{C64, Order};
use rijke_rig::{GasState, Rig};
use std::sync::Arc;

/// A network for one operating point, and the laws that fill its coefficients.
#[derive(Clone, Debug)]
pub struct PointModel<'a> {
    pub(crate) assembly: &'a Assembly,
    id: String,
    network: Network,
    pub(crate) laws: Vec<LawAt>,
    /// For each law, one for its surroundings alone, if it has been prepared and there is one.
    pub(crate) prepared: Vec<Option<Arc<dyn Law>>>,
    pub(crate) surroundings: Vec<Surroundings>,
    /// Numbers of the laws, those of the wall first, because what it loses is a symbol of the others.
    pub(crate) order: Vec<usize>,
    places: Places,
    /// Place of the reference among the microphones that are predicted.
    pub(crate) reference: usize,
    guess: C64,
}

/// Effect number `effect` of candidate number `candidate`, evaluated in surroundings number `around`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LawAt {
    pub(crate) candidate: usize,
    pub(crate) effect: usize,
    pub(crate) around: usize,
}

/// The estimate of the error of an eigenvalue, relative to |s|, that ends its search. The estimate is that of the last term
/// taken, so the error itself is smaller by the distance of the guess over that of the modes: near rounding.
const EIGENVALUE_TOLERANCE: f64 = 1e-11;

/// The laws of one effect at many places. Where the law is a number of the local gas times something that is the same
/// everywhere, all places share one law with a weight; elsewhere places of the same gas do.
#[derive(Default)]
struct Shared {
    /// The law, and its number at the place where it is evaluated.
    scaled: Option<(usize, f64)>,
    /// Surroundings and law.
    own: Vec<(usize, usize)>,
}

impl<'a> PointModel<'a> {
    /// Lays out the network. `microphones` are those predicted, in order, the reference among them.
    ///
    /// # Errors
    /// [`ModelError::Microphone`]; [`ModelError::Network`] for a geometry that is impossible.
    pub fn new(
        assembly: &'a Assembly,
        conditions: &Conditions,
        microphones: &[usize],
    ) -> Result<Self, ModelError> {
        let Conditions { point, base, ambient } = conditions;
        let rig = &assembly.rig;
        let fail = |source| ModelError::Network { point: point.id.clone(), source };
        let (length, reference) = (rig.tube.length, rig.microphones.reference);
        let count = rig.microphones.positions.len();
        if let Some(&microphone) = microphones.iter().find(|m| **m >= count) {
            return Err(ModelError::Microphone { microphone, count });
        }
        let Some(place) = microphones.iter().position(|m| *m == reference) else {
            return Err(ModelError::Microphone { microphone: reference, count });
        };
        let positions: Vec<f64> = microphones.iter().map(|&m| rig.microphones.positions[m]).collect();

        let thermocouples: &[f64] = if point.thermocouples { &rig.thermocouples } else { &[] };
        let plates = elements::plates(rig, point);
        let grid = elements::grid(assembly.scheme, base, length);
        let cuts = positions.iter().chain(thermocouples).chain(&grid).chain(&plates).copied();
        let stretches = elements::between(cuts.chain(point.position), rig, point, base);
        let segment = |s: &Stretch| Segment::new(s.to - s.from, rig.tube.area(), s.sound_speed, s.density);
        let network = Network::new(stretches.iter().map(segment).collect()).map_err(fail)?;

        let places = Places {
            at: positions.iter().map(|x| network.place_at(*x)).collect::<Result<_, _>>().map_err(fail)?,
            reference: network.place_at(rig.microphones.positions[reference]).map_err(fail)?,
        };
        let travel =
            base.travel_time(0.0, length) + 1.22 * rig.tube.radius() / base.sound_speed(0.5 * length);
        let guess = C64::new(-10.0, std::f64::consts::PI / travel);
        let mut model = Self {
            assembly,
            id: point.id.clone(),
            network,
            laws: Vec::new(),
            prepared: Vec::new(),
            surroundings: Vec::new(),
            order: Vec::new(),
            places,
            reference: place,
            guess,
        };
        model.attach(conditions, &stretches, &grid, thermocouples, *ambient).map_err(fail)?;
        model.complete_walls();
        model.forget_unused();
        Ok(model)
    }

    /// The same model with the root search started from `guess` (say, the measured s).
    #[must_use]
    pub fn starting_from(self, guess: C64) -> Self {
        Self { guess, ..self }
    }

    /// Name of the operating point.
    #[must_use]
    pub fn id(&self) -> &str {
        &self.id
    }

    /// The network, for those who want more than s and pressures.
    #[must_use]
    pub fn network(&self) -> &Network {
        &self.network
    }

    /// The eigenvalue and the relative pressures with their derivatives in the free parameters.
    ///
    /// # Errors
    /// [`ModelError::Count`], or [`ModelError::Network`] when there is no eigenvalue near the guess.
    pub fn respond(
        &self,
        values: &[f64],
        order: Order,
        work: &mut Workspace,
    ) -> Result<Response, ModelError> {
        let (filled, root) = self.solve(values, work)?;
        let found = self.network.respond(&filled, &root, &self.places, order, work);
        found.map_err(|source| self.no_answer(source))
    }

    /// The laws at these values, and the eigenvalue.
    pub(crate) fn solve<'m>(
        &'m self,
        values: &'m [f64],
        work: &mut Workspace,
    ) -> Result<(Filled<'m>, Root), ModelError> {
        let expected = self.assembly.parameters().len();
        if values.len() != expected {
            return Err(ModelError::Count { expected, found: values.len() });
        }
        let filled = Filled::new(self, values);
        let settings = Newton { tolerance: EIGENVALUE_TOLERANCE, ..Newton::default() };
        let root = self.network.solve(&filled, self.guess, &settings, work);
        root.map(|root| (filled, root)).map_err(|source| self.no_answer(source))
    }

    pub(crate) fn no_answer(&self, source: NetworkError) -> ModelError {
        ModelError::Network { point: self.id.clone(), source }
    }

    /// Levine and Schwinger's reflection coefficient of the open tube at `s`, in the gas of its downstream end.
    #[must_use]
    pub fn levine_schwinger(rig: &Rig, conditions: &Conditions, s: C64) -> C64 {
        let sound_speed = conditions.base.sound_speed(rig.tube.length);
        levine_schwinger::reflection(s * rig.tube.radius() / (C64::I * sound_speed))[0]
    }

    fn attach(
        &mut self,
        conditions: &Conditions,
        stretches: &[Stretch],
        grid: &[f64],
        thermocouples: &[f64],
        ambient: f64,
    ) -> Result<(), NetworkError> {
        let Conditions { point, base, .. } = conditions;
        let rig = &self.assembly.rig;
        let flow = [base.heater_velocity, base.mass_flux];
        let around = |gas: GasState| Surroundings::new(rig, point, &gas, ambient, flow);
        let inserted = point.position.unwrap_or(0.0);
        let plates = elements::plates(rig, point);
        // One set of surroundings per distinct gas: in a cold tube every segment shares it.
        let mut local: Vec<usize> = Vec::with_capacity(stretches.len());
        for (i, s) in stretches.iter().enumerate() {
            let same = i > 0 && stretches[i - 1].gas == s.gas;
            local.push(if same { local[i - 1] } else { self.note(around(s.gas)) });
        }
        let candidates = self.assembly.candidates();
        for (candidate, effect, place, coefficient) in candidates.iter().enumerate().flat_map(|(k, c)| {
            c.effects.iter().enumerate().map(move |(e, effect)| (k, e, effect.place, effect.coefficient))
        }) {
            match place {
                Place::Tube | Place::Prongs => {
                    let end = if place == Place::Tube { rig.tube.length } else { inserted };
                    self.attach_along(candidate, effect, coefficient, stretches, grid, &local, end)?;
                }
                Place::ProngEnd | Place::Heater | Place::HeaterMiddle | Place::Thermocouples => {
                    let at: &[f64] = match place {
                        Place::ProngEnd => point.position.as_slice(),
                        Place::Heater => &plates,
                        Place::HeaterMiddle if !plates.is_empty() => point.position.as_slice(),
                        Place::Thermocouples => thermocouples,
                        _ => &[],
                    };
                    let part = if place == Place::Heater { 1.0 / plates.len() as f64 } else { 1.0 };
                    let mut shared = Shared::default();
                    for &x in at {
                        let here = self.note(around(base.at(x)));
                        let (law, weight) = self.shared(candidate, effect, here, &mut shared);
                        let j = self.network.place_at(x)?;
                        self.network.attach(at_place(coefficient, j), law, part * weight)?;
                    }
                }
                Place::UpstreamEnd | Place::DownstreamEnd | Place::BothEnds => {
                    for (x, slot, not) in [
                        (0.0, Slot::Upstream, Place::DownstreamEnd),
                        (rig.tube.length, Slot::Downstream, Place::UpstreamEnd),
                    ] {
                        if place != not {
                            let here = self.note(around(base.at(x)));
                            let law = self.law(candidate, effect, here);
                            self.network.attach(slot, law, 1.0)?;
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// A law per metre over 0 <= x < `end`: in the segments, or in the jumps at `grid` of the lumped scheme.
    #[allow(clippy::too_many_arguments, reason = "one step of attach, split out for reading")]
    fn attach_along(
        &mut self,
        candidate: usize,
        effect: usize,
        coefficient: Coefficient,
        stretches: &[Stretch],
        grid: &[f64],
        local: &[usize],
        end: f64,
    ) -> Result<(), NetworkError> {
        let lumped = matches!(self.assembly.scheme, Scheme::Lumped { .. });
        let element = self.assembly.rig.tube.length / (grid.len() as f64 + 1.0);
        let mut shared = Shared::default();
        let mut before = None;
        for (i, s) in stretches.iter().enumerate().filter(|(_, s)| 0.5 * (s.from + s.to) < end) {
            // The halves of an element are of one gas.
            let (law, weight) = match before.filter(|(gas, _)| *gas == local[i]) {
                Some((_, found)) => found,
                None => self.shared(candidate, effect, local[i], &mut shared),
            };
            before = Some((local[i], (law, weight)));
            let slot = match coefficient {
                Coefficient::Mu if !lumped => Some(Slot::Viscous(i)),
                Coefficient::Ep if !lumped => Some(Slot::Thermal(i)),
                _ => None,
            };
            match slot {
                Some(slot) => self.network.attach(slot, law, weight)?,
                // Couplings that a line does not have, k_mp and k_eu per metre, act at both ends of each segment, half at each.
                None if !lumped => {
                    for j in [i, i + 1] {
                        self.network.attach(at_place(coefficient, j), law, 0.5 * weight * (s.to - s.from))?;
                    }
                }
                None => {
                    if grid.iter().any(|x| (x - s.from).abs() < 1e-9) {
                        self.network.attach(at_place(coefficient, i), law, weight * element)?;
                    }
                }
            }
        }
        Ok(())
    }

    fn note(&mut self, surroundings: Surroundings) -> usize {
        match self.surroundings.iter().position(|s| *s == surroundings) {
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
        let wall = [Coefficient::Mu, Coefficient::Ep].map(|coefficient| {
            let mut along = candidates
                .iter()
                .flat_map(|c| &c.effects)
                .filter(|e| e.place == Place::Tube && e.coefficient == coefficient);
            // A sum of two walls has no common factor in general.
            let only = along.next()?;
            if along.next().is_some() { None } else { only.law.scale(here, [None; 2]) }
        });
        candidates[candidate].effects[effect].law.scale(here, wall)
    }

    /// Keeps the surroundings in which a law is evaluated, and notes the laws of the wall first.
    fn forget_unused(&mut self) {
        let mut used: Vec<usize> = self.laws.iter().map(|law| law.around).collect();
        used.sort_unstable();
        used.dedup();
        for law in &mut self.laws {
            law.around = used.partition_point(|u| *u < law.around);
        }
        self.surroundings = used.iter().map(|&u| self.surroundings[u].clone()).collect();
        let is_wall = |k: &usize| {
            let law = &self.laws[*k];
            self.assembly.candidates()[law.candidate].effects[law.effect].place == Place::Tube
        };
        let (walls, others): (Vec<usize>, Vec<usize>) = (0..self.laws.len()).partition(is_wall);
        self.order = [walls, others].concat();
    }

    /// Adds what the laws that read the wall's loss need of it, where no segment brings it.
    fn complete_walls(&mut self) {
        let candidates = self.assembly.candidates();
        let effect = |law: &LawAt| &candidates[law.candidate].effects[law.effect];
        let mut missing = Vec::new();
        for law in self.laws.iter().filter(|l| effect(l).place != Place::Tube && effect(l).law.uses_wall()) {
            for (candidate, c) in candidates.iter().enumerate() {
                for e in (0..c.effects.len()).filter(|&e| c.effects[e].place == Place::Tube) {
                    let wall = LawAt { candidate, effect: e, around: law.around };
                    if !self.laws.contains(&wall) && !missing.contains(&wall) {
                        missing.push(wall);
                    }
                }
            }
        }
        self.laws.extend(missing);
    }
}

fn at_place(coefficient: Coefficient, j: usize) -> Slot {
    match coefficient {
        Coefficient::Mp => Slot::Mp(j),
        Coefficient::Eu => Slot::Eu(j),
        Coefficient::Ep => Slot::Ep(j),
        Coefficient::Mu | Coefficient::Reflection => Slot::Mu(j),
    }
}
