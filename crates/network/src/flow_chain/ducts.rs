//! What a chain with flow is made of: the state of the gas, ducts, what acts between them, ends.

use crate::laws::wall::Wall;
use crate::laws::{Law, WallLaw};

/// The mean state of the gas in a duct, SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowState {
    /// Pressure, Pa.
    pub pressure: f64,
    /// Density, kg/m^3.
    pub density: f64,
    /// Velocity, m/s, positive.
    pub velocity: f64,
}

impl FlowState {
    /// Speed of sound, m/s.
    #[must_use]
    pub fn sound_speed(&self, gamma: f64) -> f64 {
        (gamma * self.pressure / self.density).sqrt()
    }

    /// Mach number.
    #[must_use]
    pub fn mach(&self, gamma: f64) -> f64 {
        self.velocity / self.sound_speed(gamma)
    }
}

/// What an [`Action`] does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ActionKind {
    /// k_mu: force from velocity.
    Mu,
    /// k_mp: force from pressure.
    Mp,
    /// k_eu: heat taken by velocity (a flame has k_eu < 0).
    Eu,
    /// k_ep: heat taken by pressure.
    Ep,
    /// k_ep of a side branch: mass taken by pressure.
    Branch,
    /// Mean heat that answers to velocity: Q'/Q = law u'/U, where the reference lies. The heat is that of the
    /// temperature ratio there.
    Flame,
}

impl ActionKind {
    /// Whether it answers to velocity.
    pub(super) fn of_velocity(self) -> bool {
        matches!(self, Self::Mu | Self::Eu | Self::Flame)
    }
}

/// Where the velocity is taken that an action answers to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reference {
    /// So many metres upstream of the place; at 0 just in front of it.
    Upstream(f64),
    /// So many metres downstream; at 0 just downstream of the place. What acts in between must answer to
    /// where it stands.
    Downstream(f64),
}

/// A law that acts at the upstream end of a duct.
#[derive(Clone, Debug, PartialEq)]
pub struct Action {
    /// What it does.
    pub effect: ActionKind,
    /// The coefficient as a function of s.
    pub law: Law,
    /// For effects of velocity: where it is taken.
    pub reference: Reference,
}

/// A wall that takes from the waves: which law, the gas and diameter, and a factor.
#[derive(Clone, Debug, PartialEq)]
pub struct FlowWall {
    /// The law.
    pub law: WallLaw,
    /// Gas and tube.
    pub wall: Wall,
    /// Factor on both losses.
    pub factor: f64,
}

/// A duct of a flow chain.
#[derive(Clone, Debug, PartialEq)]
pub struct FlowDuct {
    /// Length, m.
    pub length: f64,
    /// Cross-section, m^2.
    pub area: f64,
    /// p/rho (gas constant times temperature) behind its upstream end over that before; 1 where nothing heats
    /// and the gas stays the same.
    pub ratio: f64,
    /// Ratio of specific heats of its gas; that of the gas before if none.
    pub gamma: Option<f64>,
    /// Whether its area and that of the duct upstream belong to one smooth wall, so that a wider duct
    /// downstream costs no pressure.
    pub smooth: bool,
    /// What acts at its upstream end. The first duct has nothing before it: there nothing may act.
    pub actions: Vec<Action>,
    /// Losses at its wall.
    pub wall: Option<FlowWall>,
}

impl FlowDuct {
    /// A plain duct of this length (m) and area (m^2).
    #[must_use]
    pub fn new(length: f64, area: f64) -> Self {
        Self { length, area, ratio: 1.0, gamma: None, smooth: false, actions: Vec::new(), wall: None }
    }

    /// With heat at its upstream end that raises the temperature by `ratio` and does not fluctuate.
    #[must_use]
    pub fn heated(self, ratio: f64) -> Self {
        Self { ratio, ..self }
    }

    /// Of gas with this ratio of specific heats.
    #[must_use]
    pub fn of_gas(self, gamma: f64) -> Self {
        Self { gamma: Some(gamma), ..self }
    }

    /// With a law acting at its upstream end.
    #[must_use]
    pub fn with(mut self, effect: ActionKind, law: Law) -> Self {
        self.actions.push(Action { effect, law, reference: Reference::Upstream(0.0) });
        self
    }

    /// With a law that answers to the velocity elsewhere.
    #[must_use]
    pub fn referring(mut self, effect: ActionKind, law: Law, reference: Reference) -> Self {
        self.actions.push(Action { effect, law, reference });
        self
    }
}

/// What closes an end.
#[derive(Clone, Debug, PartialEq)]
pub enum FlowEnd {
    /// A reflection coefficient (f/g upstream, g/f downstream).
    Reflection(Law),
    /// A compact choked nozzle. Downstream it keeps the Mach number in front of it, so that entropy waves
    /// sound there (Marble & Candel 1977); upstream it keeps mass flow and stagnation enthalpy and sheds
    /// entropy waves (Stow, Dowling & Hynes 2002).
    Choked,
}
