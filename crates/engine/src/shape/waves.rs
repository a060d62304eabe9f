//! Waves whose propagation constants are laws.

use super::fill::FilledShape;
use super::model::{LawOf, ShapeModel};
use rijke_numerics::{C64, Jet};
use rijke_study::{Coefficient, Place};

impl ShapeModel<'_> {
    /// Whether candidates state propagation constants, with which the network has nothing to do.
    pub(crate) fn has_waves(&self) -> bool {
        let wave = |law: &LawOf| matches!(*law, LawOf::Effect { candidate, effect, .. } if self.effect(candidate, effect).coefficient.is_wave());
        self.laws.iter().any(wave)
    }
}

impl FilledShape<'_> {
    /// The pressure by place of a wave that enters at an end, and has pressure 1 there: exp of the integral
    /// of its propagation constant.
    pub(crate) fn carried(&self, s: C64, source: &Place) -> Vec<Jet> {
        let model = self.model();
        let space = self.space();
        let s = space.seed(space.seeds() - 1, s);
        let walls = self.walls(&s);
        let downstream = *source == Place::Upstream;
        let kind = if downstream { Coefficient::Forward } else { Coefficient::Backward };
        let mut constants: Vec<Jet> = model.ducts.iter().map(|_| space.real(0.0)).collect();
        for law in &model.laws {
            let LawOf::Effect { candidate, effect, around } = *law else { continue };
            if model.effect(candidate, effect).coefficient == kind {
                let duct = model.surroundings[around].0[0];
                constants[duct] = &constants[duct] + &self.effect([candidate, effect, around], &s, &walls);
            }
        }
        let phases =
            self.lengths().iter().zip(&model.duct_of).map(|(length, duct)| length * &constants[*duct]);
        let mut along = vec![space.real(0.0)];
        for phase in phases {
            let next = along.last().map_or_else(|| phase.clone(), |before| before + &phase);
            along.push(next);
        }
        let end = along.last().cloned().unwrap_or_else(|| space.real(0.0));
        let one = |phase: &Jet| if downstream { (-phase).exp() } else { (phase - &end).exp() };
        along.iter().map(one).collect()
    }
}
