//! Chains with mean flow: two acoustic waves and an entropy wave in every duct, Mach numbers below 0.3.
//!
//! In a duct of mean velocity U the disturbances obey s rho u + rho U u' + p' = -kappa_mu u and
//! (s p + U p')/(rho c^2) + u' = -kappa_ep p (primes: d/dx); what density has beyond p/c^2 is carried along with U. Where
//! ducts meet, the linearised balances of mass, momentum and energy hold, in two steps:
//!
//! 1. the area changes. An expansion keeps p A_2 + rho u^2 A over the step (the pressure on the face is the upstream one:
//!    Borda and Carnot); a contraction keeps p/rho^gamma, and so does a step of a smooth wall ([`FlowDuct::smooth`]);
//! 2. heat and devices act. Mean heat raises the temperature by a ratio and by itself does not fluctuate per volume; k_mu u
//!    and k_mp p are forces on the gas, k_eu u and k_ep p take heat of gamma p/(gamma-1) times themselves per area, a flame
//!    gives Q'/Q = F u'/U, and a side branch takes mass with the stagnation enthalpy and axial velocity of the stream. u and p are those upstream of
//!    the place, as in [`crate::Network`], to which the chain tends as the flow slows down.
//!
//! The gas is perfect with constant gamma. Entropy waves do not disperse, or are left out
//! ([`FlowChain::without_entropy_waves`]).

mod along;
mod attach;
mod budget;
mod chain;
mod forced;
mod gate;
mod mean;
pub(crate) mod number;
mod passage;
mod reference;
mod response;
mod sensitivity;

pub use attach::FlowSlot;
pub use budget::FlowBudget;
pub use reference::Reference;
pub use response::FlowParameter;
pub use sensitivity::{FlowDerivatives, FlowSensitivities};

use crate::contour::{Modes, Region};
use crate::error::NetworkError;
use crate::laws::{Law, WallLaw};
use crate::newton::{Newton, Root, iterate};
use crate::search::zeros;
use crate::sweep::Dual;
use crate::wall::Wall;
use attach::Attached;
use gate::Basis;
use mean::Mean;
use reference::Ear;
use rijke_numerics::C64;

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
pub enum Effect {
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
    /// Mean heat that answers to velocity: Q'/Q = law u'/U, where the reference lies. The heat is that of the temperature
    /// ratio there.
    Flame,
}

impl Effect {
    /// Whether it answers to velocity.
    fn of_velocity(self) -> bool {
        matches!(self, Self::Mu | Self::Eu | Self::Flame)
    }
}

/// A law that acts at the upstream end of a duct.
#[derive(Clone, Debug, PartialEq)]
pub struct Action {
    /// What it does.
    pub effect: Effect,
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
    /// Temperature behind its upstream end over that before; 1 where nothing heats.
    pub ratio: f64,
    /// Whether its area and that of the duct before belong to one smooth wall, so that a wider duct behind costs no pressure.
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
        Self { length, area, ratio: 1.0, smooth: false, actions: Vec::new(), wall: None }
    }

    /// With heat at its upstream end that raises the temperature by `ratio` and does not fluctuate.
    #[must_use]
    pub fn heated(self, ratio: f64) -> Self {
        Self { ratio, ..self }
    }

    /// With a law acting at its upstream end.
    #[must_use]
    pub fn with(mut self, effect: Effect, law: Law) -> Self {
        self.actions.push(Action { effect, law, reference: Reference::Upstream(0.0) });
        self
    }

    /// With a law that answers to the velocity elsewhere.
    #[must_use]
    pub fn hearing(mut self, effect: Effect, law: Law, reference: Reference) -> Self {
        self.actions.push(Action { effect, law, reference });
        self
    }
}

/// What closes an end.
#[derive(Clone, Debug, PartialEq)]
pub enum FlowEnd {
    /// A reflection coefficient (f/g upstream, g/f downstream).
    Reflection(Law),
    /// A compact choked nozzle. Downstream it keeps the Mach number in front of it, so that entropy waves sound there
    /// (Marble & Candel 1977); upstream it keeps mass flow and stagnation enthalpy and sheds entropy waves (Stow, Dowling
    /// & Hynes 2002).
    Choked,
}

/// A chain of ducts with mean flow.
///
/// ```
/// use rijke_network::flow_chain::{FlowChain, FlowDuct, FlowEnd, FlowState};
/// use rijke_network::{Region, laws::Law};
/// use rijke_numerics::C64;
/// let inlet = FlowState { pressure: 101_325.0, density: 1.2041, velocity: 3.4 };
/// let end = FlowEnd::Reflection(Law::Constant(C64::new(-0.95, 0.0)));
/// let chain = FlowChain::new(1.4, inlet, vec![FlowDuct::new(1.0, 1.0)], [end.clone(), end]).unwrap();
/// let modes = chain.modes(&Region { sigma: [-50.0, 10.0], omega: [100.0, 4000.0] }).unwrap();
/// assert_eq!(modes.modes.len(), 3);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FlowChain {
    gamma: f64,
    inlet: FlowState,
    ducts: Vec<FlowDuct>,
    ends: [FlowEnd; 2],
    entropy_waves: bool,
    states: Vec<FlowState>,
    ears: Vec<Ear>,
    attached: Vec<Attached>,
    /// Constant losses per metre beside those of walls: viscous, thermal.
    losses: Vec<[C64; 2]>,
    /// The chain without laws of a caller.
    basis: Basis<Dual>,
}

impl FlowChain {
    /// The chain behind an inlet state; the mean states of the other ducts follow from the balances. `ends` are the
    /// upstream and the downstream one.
    ///
    /// # Errors
    /// [`NetworkError::Empty`]; [`NetworkError::Segment`] for a length, area, temperature ratio or inlet quantity that is
    /// not positive; [`NetworkError::TooFast`] for M >= 0.3, 1 or more where the flow would choke; [`NetworkError::ActionAtInlet`];
    /// [`NetworkError::Outside`] for a reference beyond the chain; [`NetworkError::ReferenceCrossed`].
    pub fn new(
        gamma: f64,
        inlet: FlowState,
        ducts: Vec<FlowDuct>,
        ends: [FlowEnd; 2],
    ) -> Result<Self, NetworkError> {
        if ducts.is_empty() {
            return Err(NetworkError::Empty);
        }
        for (index, duct) in ducts.iter().enumerate() {
            let named = [
                ("length", duct.length),
                ("area", duct.area),
                ("temperature ratio", duct.ratio),
                ("inlet pressure", inlet.pressure),
                ("inlet density", inlet.density),
                ("inlet velocity", inlet.velocity),
            ];
            if let Some(&(quantity, value)) = named.iter().find(|(_, v)| !(v.is_finite() && *v > 0.0)) {
                return Err(NetworkError::Segment { index, quantity, value });
            }
            if index == 0 && !(duct.actions.is_empty() && duct.ratio == 1.0) {
                return Err(NetworkError::ActionAtInlet);
            }
        }
        let ears = Ear::all(&ducts)?;
        let one = Dual::constant(C64::ONE);
        let basis = Basis::plain(&one, gamma, inlet, &ducts);
        let states: Vec<FlowState> = basis.after.iter().map(state_of).collect();
        basis.check(gamma)?;
        let losses = vec![[C64::ZERO; 2]; ducts.len()];
        let attached = Vec::new();
        Ok(Self { gamma, inlet, ducts, ends, entropy_waves: true, states, ears, attached, losses, basis })
    }

    /// The same chain with entropy waves that are lost in every duct, as shear and turbulence do to them in slow flows.
    /// Carried without loss they grow like e^{-sigma l/u} backwards in time, which for decaying modes in slow flows
    /// drowns the acoustics in rounding.
    #[must_use]
    pub fn without_entropy_waves(mut self) -> Self {
        self.entropy_waves = false;
        self
    }

    /// The same chain with other ends, upstream and downstream.
    #[must_use]
    pub fn with_ends(self, ends: [FlowEnd; 2]) -> Self {
        Self { ends, ..self }
    }

    /// The ducts, from upstream to downstream.
    #[must_use]
    pub fn ducts(&self) -> &[FlowDuct] {
        &self.ducts
    }

    /// Mean states of the ducts.
    #[must_use]
    pub fn states(&self) -> &[FlowState] {
        &self.states
    }

    /// Time that sound needs through the chain and back, over two, s.
    #[must_use]
    pub fn travel_time(&self) -> f64 {
        let time = |(d, s): (&FlowDuct, &FlowState)| {
            let c = s.sound_speed(self.gamma);
            d.length * c / (c * c - s.velocity * s.velocity)
        };
        self.ducts.iter().zip(&self.states).map(time).sum()
    }

    /// Every mode in `region`, counted as by [`crate::Network::modes`].
    ///
    /// # Errors
    /// As [`crate::Network::modes`].
    pub fn modes(&self, region: &Region) -> Result<Modes, NetworkError> {
        region.check()?;
        let step = 0.25 * std::f64::consts::PI / self.travel_time();
        let poles = self.poles(&region.widened(4.0 * step))?;
        let inside = poles.iter().filter(|p| region.contains(p.0)).map(|p| p.1).sum();
        zeros(|s| self.characteristic(s), region, step, poles, inside)
    }

    /// Poles of the laws that act, with their orders: all that lie in `region`, others may be among them.
    ///
    /// # Errors
    /// As [`Law::poles_in`].
    pub fn poles(&self, region: &Region) -> Result<Vec<(C64, usize)>, NetworkError> {
        let reflections = self.ends.iter().filter_map(|end| match end {
            FlowEnd::Reflection(law) => Some(law),
            FlowEnd::Choked => None,
        });
        let mut poles = Vec::new();
        for law in self.ducts.iter().flat_map(|d| d.actions.iter().map(|a| &a.law)).chain(reflections) {
            poles.extend(law.poles_in(region)?);
        }
        Ok(poles)
    }

    /// The eigenvalue to which Newton's iteration from `guess` leads.
    ///
    /// # Errors
    /// As [`crate::Network::solve`].
    pub fn solve(&self, guess: C64, settings: &Newton) -> Result<Root, NetworkError> {
        let spacing = std::f64::consts::PI / self.travel_time();
        iterate(guess, spacing, settings, |s| {
            self.sweep(&self.basis, &Dual { v: s, d: C64::ONE }, |_, _, _| ())
        })
    }

    /// F(s) = g - R_d f at the outlet for g = 1 and no entropy wave at the inlet, and dF/ds.
    #[must_use]
    pub fn characteristic(&self, s: C64) -> [C64; 2] {
        let f = self.sweep(&self.basis, &Dual { v: s, d: C64::ONE }, |_, _, _| ());
        [f.v, f.d]
    }
}

fn state_of(mean: &Mean<Dual>) -> FlowState {
    FlowState { pressure: mean.pressure.v.re, density: mean.density.v.re, velocity: mean.velocity.v.re }
}
