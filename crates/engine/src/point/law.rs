//! One law of a point by itself.

use super::model::PointModel;
use crate::shape::LawOf;
use rijke_network::{At, Coefficients, Laws};
use rijke_numerics::{C64, Order};

impl PointModel<'_> {
    /// The law of effect `effect` of candidate `candidate` at s, and its derivatives with respect to the free
    /// parameters; none if nothing here follows that law.
    pub(crate) fn law_at(
        &self,
        values: &[f64],
        s: C64,
        [candidate, effect]: [usize; 2],
    ) -> Option<(C64, Vec<C64>)> {
        let asked = [candidate, effect];
        let law = match &self.shape {
            Some(shape) => shape.laws.iter().position(|law| match *law {
                LawOf::Effect { candidate, effect, .. } => [candidate, effect] == asked,
                _ => false,
            }),
            None => self.laws.iter().position(|law| [law.candidate, law.effect] == asked),
        };
        let (law, filled) = (law?, self.filled(values).ok()?);
        let laws = laws_at(&*filled, &At::full(s, values.len(), Order::First));
        Some((laws.value(law), laws.gradient(law)[..values.len()].to_vec()))
    }

    /// The first law that has no finite value at s, as messages call it.
    pub(crate) fn undefined(&self, values: &[f64], s: C64) -> Option<String> {
        let filled = self.filled(values).ok()?;
        let laws = laws_at(&*filled, &At::search(s));
        (0..filled.laws()).find(|k| !laws.value(*k).is_finite()).map(|k| filled.name(k))
    }

    /// Values of all laws at s = i omega; nothing in rigs whose lengths are unknown.
    pub(super) fn law_values(&self, values: &[f64], omega: f64) -> Vec<C64> {
        if self.shape.is_some() {
            return Vec::new();
        }
        let Ok(filled) = self.filled(values) else { return Vec::new() };
        let laws = laws_at(&*filled, &At::search(C64::new(0.0, omega)));
        (0..self.laws.len()).map(|k| laws.value(k)).collect()
    }
}

fn laws_at(filled: &dyn Coefficients, at: &At) -> Laws {
    let mut laws = Laws::default();
    laws.reset(filled.laws(), at);
    filled.fill(at, &mut laws);
    laws
}
