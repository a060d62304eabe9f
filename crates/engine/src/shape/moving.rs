//! The laws of a mode: in s alone while it is searched, then with the derivatives that are wanted.

use super::fill::FilledShape;
use super::model::{LawOf, ShapeModel};
use crate::EngineError;
use crate::point::{Acting, poles};
use rijke_network::{At, Coefficients, Laws, NetworkError, Pole, Region};
use rijke_numerics::{C64, JetSpace, Order};

/// The laws at given values of the free parameters.
pub(crate) struct Moving<'m> {
    model: &'m ShapeModel<'m>,
    values: &'m [f64],
    in_s: FilledShape<'m>,
}

impl<'m> Moving<'m> {
    /// # Errors
    /// [`EngineError::Impossible`] where a length, an area or a temperature is not positive.
    pub(crate) fn new(
        model: &'m ShapeModel<'m>,
        values: &'m [f64],
        point: &str,
    ) -> Result<Self, EngineError> {
        let in_s = FilledShape::new(model, values, JetSpace::new(1, Order::First), point)?;
        Ok(Self { model, values, in_s })
    }
}

impl Coefficients for Moving<'_> {
    fn parameters(&self) -> usize {
        self.values.len()
    }

    fn laws(&self) -> usize {
        self.model.laws.len()
    }

    fn fill(&self, at: &At, laws: &mut Laws) {
        if at.space() == self.in_s.space() {
            self.in_s.fill(at, laws);
        } else {
            FilledShape::unchecked(self.model, self.values, at.space()).fill(at, laws);
        }
    }

    fn poles_in(&self, region: &Region) -> Result<Vec<Pole>, NetworkError> {
        let acting = |(k, law): (usize, &LawOf)| {
            let LawOf::Effect { candidate, effect, around } = *law else { return None };
            let acts = self.model.effect(candidate, effect);
            let owner = [candidate, around];
            (!acts.place.is_along()).then_some(Acting { law: k, owner, formula: acts.law.clone() })
        };
        let acting: Vec<Acting> = self.model.laws.iter().enumerate().filter_map(acting).collect();
        Ok(poles(&acting, region, self.model.spacing, |k, part, s| {
            let LawOf::Effect { candidate, effect, around } = self.model.laws[k] else {
                return [C64::ONE; 2];
            };
            let s = self.in_s.space().seed(0, s);
            let found = self.in_s.part(part, [candidate, effect, around], &s, &[]);
            [found.value(), found.gradient()[0]]
        }))
    }

    fn name(&self, law: usize) -> String {
        let Some(LawOf::Effect { candidate, effect, .. }) = self.model.laws.get(law) else {
            return "the shape of the rig".to_owned();
        };
        let (effect, owner) =
            (self.model.effect(*candidate, *effect), &self.model.assembly.candidates()[*candidate]);
        format!("{} of {} at {}", effect.coefficient.name(), owner.id, effect.place_text)
    }
}
