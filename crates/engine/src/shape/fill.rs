//! The laws at given values of the free parameters.

use super::extents::Extents;
use super::gas::SPEED;
use super::model::{LawOf, ShapeModel};
use crate::EngineError;
use crate::assembly::part_of_wall;
use rijke_formula::{Formula, Here};
use rijke_network::{At, Coefficients, Laws, laws::Law, levine_schwinger};
use rijke_numerics::{C64, Jet, JetSpace};
use rijke_study::names::{
    AREA, AREA_AFTER, DENSITY, DENSITY_AFTER, DIAMETER, FLANGED, LENGTH, LEVINE_SCHWINGER, MACH, MASS_FLUX,
    PERIMETER, S, SOUND_SPEED, TEMPERATURE, TEMPERATURE_AFTER, VELOCITY, WALL_EP, WALL_MU,
};

/// Names that may carry derivatives are the first of the scope.
const NAMES: usize = DENSITY_AFTER + 1;

/// A model at given values of the free parameters.
pub(crate) struct FilledShape<'m> {
    model: &'m ShapeModel<'m>,
    space: JetSpace,
    /// The parameters of each candidate.
    parameters: Vec<Vec<Jet>>,
    extents: Extents,
    /// Whether lengths, areas or temperatures are unknown.
    moving: bool,
}

impl<'m> FilledShape<'m> {
    /// In a space of the free parameters and s, or of s alone.
    ///
    /// # Errors
    /// [`EngineError::Impossible`] where a length, an area or a temperature is not positive.
    pub(crate) fn new(
        model: &'m ShapeModel<'m>,
        values: &[f64],
        space: JetSpace,
        point: &str,
    ) -> Result<Self, EngineError> {
        let filled = Self::unchecked(model, values, space);
        let impossible = || EngineError::Impossible { point: point.to_owned() };
        if filled.is_possible() { Ok(filled) } else { Err(impossible()) }
    }

    /// As [`FilledShape::new`], of lengths and areas that are known to be possible.
    pub(super) fn unchecked(model: &'m ShapeModel<'m>, values: &[f64], space: JetSpace) -> Self {
        let assembly = model.assembly;
        let candidates = assembly.candidates();
        let parameters: Vec<Vec<Jet>> = if space.seeds() == values.len() + 1 {
            let all: Vec<usize> = (0..values.len()).collect();
            (0..candidates.len()).map(|k| assembly.jets(k, &all, space, values)).collect()
        } else {
            let constants = |numbers: Vec<f64>| numbers.into_iter().map(|v| space.real(v)).collect();
            assembly.numbers(values).into_iter().map(constants).collect()
        };
        let own = candidates.iter().position(|c| c.role == "rig").map_or(&[][..], |k| &parameters[k]);
        let extents = model.extents(space, own);
        let moving = model.assembly.rig.is_of_unknown_shape();
        Self { model, space, parameters, extents, moving }
    }

    /// The model whose laws these are.
    pub(super) fn model(&self) -> &'m ShapeModel<'m> {
        self.model
    }

    /// Length of every segment, m.
    pub(super) fn lengths(&self) -> &[Jet] {
        &self.extents.lengths
    }

    /// The space of the jets.
    pub(super) fn space(&self) -> JetSpace {
        self.space
    }

    /// Whether all lengths and areas are those of a tube, with gas in it.
    fn is_possible(&self) -> bool {
        let positive = |jet: &Jet| jet.value().re > 0.0 && jet.value().re.is_finite();
        let Extents { lengths, areas, gas, .. } = &self.extents;
        lengths.iter().chain(areas).chain(gas.iter().flatten().flatten()).all(positive)
    }

    /// Area of the first duct, m^2.
    pub(crate) fn first_area(&self) -> &Jet {
        &self.extents.areas[0]
    }

    /// The value of an effect at s, in surroundings of number `around`; `walls` are what the walls of the
    /// ducts lose.
    pub(crate) fn effect(&self, ids: [usize; 3], s: &Jet, walls: &[[Jet; 2]]) -> Jet {
        self.part(&self.model.effect(ids[0], ids[1]).law, ids, s, walls)
    }

    /// As [`FilledShape::effect`], of a part of its formula.
    pub(super) fn part(
        &self,
        formula: &Formula,
        [candidate, effect, around]: [usize; 3],
        s: &Jet,
        walls: &[[Jet; 2]],
    ) -> Jet {
        let law = self.model.effect(candidate, effect);
        let ([before, after], numbers) = &self.model.surroundings[around];
        let (before, after) = (*before, *after);
        let mut analytic: [Option<&Jet>; NAMES] = [None; NAMES];
        analytic[S] = Some(s);
        let (perimeter, flux, velocity, mach);
        if self.moving {
            let Extents { areas, diameters, length, gas, .. } = &self.extents;
            if let Some(gas) = &gas[before] {
                for (name, property) in (DENSITY..).zip(gas) {
                    analytic[name] = Some(property);
                }
            }
            if let Some(gas) = &gas[after] {
                analytic[TEMPERATURE_AFTER] = Some(&gas[TEMPERATURE - DENSITY]);
                analytic[DENSITY_AFTER] = Some(&gas[0]);
            }
            if [MASS_FLUX, VELOCITY, MACH].into_iter().any(|name| formula.uses(name)) {
                let known = |name: usize| self.space.real(numbers[name]);
                let [density, speed] = [DENSITY, SOUND_SPEED].map(|name| {
                    gas[before].as_ref().map_or_else(|| known(name), |g| g[name - DENSITY].clone())
                });
                flux = areas[before].recip().scale(C64::new(self.model.mass_flow, 0.0));
                velocity = &flux * &density.recip();
                mach = &velocity * &speed.recip();
                analytic[MASS_FLUX] = Some(&flux);
                analytic[VELOCITY] = Some(&velocity);
                analytic[MACH] = Some(&mach);
            }
            perimeter = diameters[before].scale(C64::new(std::f64::consts::PI, 0.0));
            analytic[DIAMETER] = Some(&diameters[before]);
            analytic[AREA] = Some(&areas[before]);
            analytic[AREA_AFTER] = Some(&areas[after]);
            analytic[PERIMETER] = Some(&perimeter);
            analytic[LENGTH] = Some(length);
        }
        if let (Some([mu, ep]), None) = (walls.get(before), part_of_wall(law)) {
            (analytic[WALL_MU], analytic[WALL_EP]) = (Some(mu), Some(ep));
        }
        let (unflanged, flanged);
        if law.place.is_end() {
            // ka = s a/(i c).
            let radius = self.extents.diameters[before].scale(C64::new(0.5, 0.0));
            let x = s * &radius;
            let x = match &self.extents.gas[before] {
                Some(gas) => &x * &gas[SPEED].recip(),
                None => x.scale(C64::new(1.0 / numbers[SOUND_SPEED], 0.0)),
            };
            if formula.uses(LEVINE_SCHWINGER) {
                let turn = -C64::I;
                let [value, slope, bend] = levine_schwinger::reflection(x.value() * turn);
                unflanged = x.compose(value, slope * turn, bend * turn * turn);
                analytic[LEVINE_SCHWINGER] = Some(&unflanged);
            }
            if formula.uses(FLANGED) {
                let [value, slope, bend] = Law::Flanged { radius: 1.0, sound_speed: 1.0 }.analytic(x.value());
                flanged = x.compose(value, slope, bend);
                analytic[FLANGED] = Some(&flanged);
            }
        }
        let here = Here { space: self.space, numbers, analytic: &analytic };
        formula.evaluate(&here, &self.parameters[candidate])
    }

    /// What a property of the gas of segment `i` has beyond `known`.
    fn gas_of(&self, i: usize, property: usize, known: f64) -> Jet {
        let gas = self.extents.gas[self.model.duct_of[i]].as_ref();
        gas.map_or_else(|| self.space.real(0.0), |gas| gas[property].shift(C64::new(-known, 0.0)))
    }

    /// What the wall of every duct loses per metre: viscous and thermal.
    pub(crate) fn walls(&self, s: &Jet) -> Vec<[Jet; 2]> {
        let zero = || self.space.real(0.0);
        let mut walls: Vec<[Jet; 2]> = self.model.ducts.iter().map(|_| [zero(), zero()]).collect();
        for law in &self.model.laws {
            let LawOf::Effect { candidate, effect, around } = *law else { continue };
            if let Some(part) = part_of_wall(self.model.effect(candidate, effect)) {
                let duct = self.model.surroundings[around].0[0];
                let lost = self.effect([candidate, effect, around], s, &[]);
                walls[duct][part] = &walls[duct][part] + &lost;
            }
        }
        walls
    }
}

impl Coefficients for FilledShape<'_> {
    fn parameters(&self) -> usize {
        self.space.seeds() - 1
    }

    fn laws(&self) -> usize {
        self.model.laws.len()
    }

    fn fill(&self, at: &At, laws: &mut Laws) {
        let s = at.s_jet();
        let walls = self.walls(&s);
        let segments = self.model.network.segments();
        for (k, law) in self.model.laws.iter().enumerate() {
            let value = match *law {
                LawOf::Effect { candidate, effect, around } => {
                    self.effect([candidate, effect, around], &s, &walls)
                }
                LawOf::Length(i) => self.extents.lengths[i].shift(C64::new(-segments[i].length, 0.0)),
                LawOf::Area(i) => {
                    self.extents.areas[self.model.duct_of[i]].shift(C64::new(-segments[i].area, 0.0))
                }
                LawOf::SoundSpeed(i) => self.gas_of(i, SPEED, segments[i].sound_speed),
                LawOf::Density(i) => self.gas_of(i, 0, segments[i].density),
            };
            laws.set(k, &value);
        }
    }
}
