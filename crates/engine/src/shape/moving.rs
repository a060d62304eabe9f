//! The laws of a mode: in s alone while it is searched, then with the derivatives that are wanted.

use super::fill::Filled;
use super::model::{LawOf, ShapeModel};
use crate::EngineError;
use rijke_network::{At, Coefficients, Laws};
use rijke_numerics::{JetSpace, Order};

/// The laws at given values of the free parameters.
pub(crate) struct Moving<'m> {
    model: &'m ShapeModel<'m>,
    values: &'m [f64],
    in_s: Filled<'m>,
}

impl<'m> Moving<'m> {
    /// # Errors
    /// [`EngineError::Impossible`] where a length or an area is not positive.
    pub(crate) fn new(
        model: &'m ShapeModel<'m>,
        values: &'m [f64],
        point: &str,
    ) -> Result<Self, EngineError> {
        let in_s = Filled::new(model, values, JetSpace::new(1, Order::First), point)?;
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
            Filled::unchecked(self.model, self.values, at.space()).fill(at, laws);
        }
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
