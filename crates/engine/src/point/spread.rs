//! Flames that release their heat along ducts: where their pieces are, and what laws see there.

use crate::conditions::Conditions;
use rijke_network::laws::spread_middle;
use rijke_study::names::{DENSITY_AFTER, TEMPERATURE_AFTER};
use rijke_study::{Effect, RigAtPoint, Spread};

/// A flame of a rig at an operating point.
pub(super) struct SpreadAt<'a> {
    spread: &'a Spread,
    /// Where it begins, m.
    from: f64,
    /// How far it reaches, m.
    length: f64,
}

/// The flames that an effect has there; none if it acts at places.
pub(super) fn flames<'a>(effect: &'a Effect, layout: &RigAtPoint) -> Vec<SpreadAt<'a>> {
    let Some(spread) = effect.hears.as_ref().and_then(|hears| hears.spread.as_ref()) else {
        return Vec::new();
    };
    let places = layout.places(&effect.place).into_iter();
    places.map(|(x, _)| SpreadAt::new(spread, x, layout)).collect()
}

impl<'a> SpreadAt<'a> {
    pub(super) fn new(spread: &'a Spread, from: f64, layout: &RigAtPoint) -> Self {
        Self { spread, from, length: layout.numbers[spread.length] }
    }

    /// Where it ends, m.
    pub(super) fn end(&self) -> f64 {
        self.from + self.length
    }

    /// Where its pieces release their heat, m.
    pub(super) fn middles(&self) -> impl Iterator<Item = f64> {
        let pieces = self.spread.pieces;
        (0..pieces).map(move |k| self.from + self.length * spread_middle(k, pieces))
    }

    /// Where ducts are cut for it, m.
    pub(super) fn cuts(&self) -> impl Iterator<Item = f64> {
        self.middles().chain([self.end()])
    }

    /// What the law of each piece sees: what is before the flame and, behind, the gas at its end.
    pub(super) fn around(&self, conditions: &Conditions) -> impl Iterator<Item = Vec<f64>> {
        let mut all = conditions.around(self.from);
        (all[TEMPERATURE_AFTER], all[DENSITY_AFTER]) = conditions.behind(self.end());
        let Spread { along, pieces, .. } = *self.spread;
        (0..pieces).map(move |k| {
            let mut here = all.clone();
            here[along] = spread_middle(k, pieces);
            here
        })
    }
}
