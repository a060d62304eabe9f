//! What a candidate is: parameters, and effects at places.

use crate::{Dual, Formula, Here, Surroundings, Symbol};
use rijke_numerics::{Jet, JetSpace, Order};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// One competing model of one component.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Unique name, `"prongs.6"`.
    pub id: String,
    /// The component that it models; candidates of one role compete.
    pub role: String,
    /// What it is called in tables.
    pub name: String,
    /// Where it comes from.
    pub cite: Vec<String>,
    /// Anything else that a reader should know.
    pub note: String,
    /// Its parameters, in the order of the file.
    pub parameters: Vec<rijke_inference::Parameter>,
    /// What it does.
    pub effects: Vec<Effect>,
}

/// One law that acts on one coefficient at one kind of place.
#[derive(Clone, Debug)]
pub struct Effect {
    /// Where.
    pub place: Place,
    /// On what.
    pub coefficient: Coefficient,
    /// By how much.
    pub law: Arc<dyn Law>,
}

/// Where an effect acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Place {
    /// All along the tube; the law is a coefficient per metre, and becomes `wall_mu`, `wall_ep` for other laws.
    Tube,
    /// Along 0 <= x < X_h, where the prongs and feed wires are; the law is a coefficient per metre.
    Prongs,
    /// The end of the prongs, x = X_h, with or without the heater.
    ProngEnd,
    /// The two plates of the heater, when it is attached: half of the effect at the middle of each, in the gas there.
    Heater,
    /// The middle of the heater, x = X_h, when it is attached: all of the effect at once, in the gas there, as in the jump conditions
    /// (1) and (2) of Juniper & Yoko 2022.
    HeaterMiddle,
    /// Each thermocouple, when they are in place.
    Thermocouples,
    /// The end x = 0.
    UpstreamEnd,
    /// The end x = L.
    DownstreamEnd,
    /// Both ends alike.
    BothEnds,
}

/// The coefficient that an effect adds to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Coefficient {
    /// k_mu: velocity into momentum, kg/(m^2 s); per metre kg/(m^3 s).
    Mu,
    /// k_mp: pressure into momentum, 1; per metre 1/m.
    Mp,
    /// k_eu: velocity into energy, 1; per metre 1/m.
    Eu,
    /// k_ep: pressure into energy, m^2 s/kg = m/(Pa s); per metre 1/(Pa s).
    Ep,
    /// R at an end, both including the minus sign of an open end: |R| near 1, angle near pi.
    Reflection,
}

/// A law: local state and parameters in, coefficient out, with derivatives.
///
/// The value must be analytic in s; each parameter is a jet of the same space as `here.s`.
pub trait Law: Send + Sync + std::fmt::Debug {
    /// The coefficient.
    fn evaluate(&self, here: &Here<'_>, parameters: &[Jet]) -> Jet;

    /// The coefficient and its derivative with respect to s: all that a root search needs. The same as
    /// [`Law::evaluate`] in the single seed s, which is also how it is done unless overridden.
    fn evaluate_in_s(&self, here: &Here<'_, Dual>, parameters: &[f64]) -> Dual {
        let space = JetSpace::new(1, Order::First);
        let jet = |x: &Dual| Jet::from_parts(x.value, vec![x.slope], Vec::new());
        let (s, wall) = (jet(here.s), here.wall.map(|w| w.map(jet)));
        let reflection = here.levine_schwinger.map(jet);
        let full = Here {
            space,
            surroundings: here.surroundings,
            s: &s,
            wall: wall.as_ref().map(|[mu, ep]| [mu, ep]),
            levine_schwinger: reflection.as_ref(),
        };
        let constants: Vec<Jet> = parameters.iter().map(|&p| space.real(p)).collect();
        let value = self.evaluate(&full, &constants);
        Dual { value: value.value(), slope: value.gradient()[0] }
    }

    /// g such that the law is g times something that does not depend on the local gas, if that is known: laws of many
    /// segments are then evaluated once. `wall` holds g of the viscous and of the thermal loss of the wall.
    fn scale(&self, _surroundings: &Surroundings, _wall: [Option<f64>; 2]) -> Option<f64> {
        None
    }

    /// The same law for these surroundings alone, where that is cheaper to evaluate.
    fn at(&self, _surroundings: &Surroundings) -> Option<Arc<dyn Law>> {
        None
    }

    /// Whether the law reads the loss of the wall.
    fn uses_wall(&self) -> bool {
        true
    }

    /// The law as text, for tables.
    fn text(&self) -> String;
}

impl Law for Formula {
    fn evaluate(&self, here: &Here<'_>, parameters: &[Jet]) -> Jet {
        Formula::evaluate(self, here, parameters)
    }

    fn evaluate_in_s(&self, here: &Here<'_, Dual>, parameters: &[f64]) -> Dual {
        Formula::evaluate_in_s(self, here, parameters)
    }

    fn scale(&self, surroundings: &Surroundings, wall: [Option<f64>; 2]) -> Option<f64> {
        Formula::scale(self, surroundings, wall)
    }

    fn at(&self, surroundings: &Surroundings) -> Option<Arc<dyn Law>> {
        Some(Arc::new(Formula::at(self, surroundings)))
    }

    fn uses_wall(&self) -> bool {
        self.uses(Symbol::WallMu) || self.uses(Symbol::WallEp)
    }

    fn text(&self) -> String {
        self.source().to_owned()
    }
}

impl Place {
    /// Whether the law is a coefficient per metre.
    #[must_use]
    pub fn is_distributed(self) -> bool {
        matches!(self, Self::Tube | Self::Prongs)
    }

    /// Whether the place is an end of the tube.
    #[must_use]
    pub fn is_end(self) -> bool {
        matches!(self, Self::UpstreamEnd | Self::DownstreamEnd | Self::BothEnds)
    }
}
