//! The chain with flow, put together: mean states follow from the inlet and the balances.

use super::ducts::{FlowDuct, FlowEnd, FlowState};
use super::gate::Basis;
use super::mean::state_of;
use super::reference_point::ReferencePoint;
use super::slots::Attached;
use crate::error::NetworkError;
use rijke_numerics::C64;
use rijke_numerics::ComplexDual;

/// A chain of ducts with mean flow.
///
/// ```
/// use rijke_network::flow_chain::{FlowChain, FlowDuct, FlowEnd, FlowState};
/// use rijke_network::{Chain, Constant, Region, Workspace, laws::Law};
/// use rijke_numerics::C64;
/// let inlet = FlowState { pressure: 101_325.0, density: 1.2041, velocity: 3.4 };
/// let end = FlowEnd::Reflection(Law::Constant(C64::new(-0.95, 0.0)));
/// let chain = FlowChain::new(1.4, inlet, vec![FlowDuct::new(1.0, 1.0)], [end.clone(), end]).unwrap();
/// let region = Region { sigma: [-50.0, 10.0], omega: [100.0, 4000.0] };
/// let modes = chain.modes(&Constant, &region, &mut Workspace::default()).unwrap();
/// assert_eq!(modes.modes.len(), 3);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FlowChain {
    pub(super) gamma: f64,
    pub(super) inlet: FlowState,
    pub(super) ducts: Vec<FlowDuct>,
    pub(super) ends: [FlowEnd; 2],
    pub(super) entropy_waves: bool,
    pub(super) states: Vec<FlowState>,
    pub(super) references: Vec<ReferencePoint>,
    pub(super) attached: Vec<Attached>,
    /// Constant losses per metre beside those of walls: viscous, thermal.
    pub(super) losses: Vec<[C64; 2]>,
    /// The chain without laws of a caller.
    pub(super) basis: Basis<ComplexDual>,
}

impl FlowChain {
    /// The chain behind an inlet state; the mean states of the other ducts follow from the balances. `ends`
    /// are the upstream and the downstream one.
    ///
    /// # Errors
    /// [`NetworkError::Empty`]; [`NetworkError::Segment`] for a length, area, temperature ratio or inlet
    /// quantity that is not positive; [`NetworkError::TooFast`] for M >= 0.3, 1 or more where the flow would
    /// choke; [`NetworkError::ActionAtInlet`]; [`NetworkError::Outside`] for a reference beyond the chain;
    /// [`NetworkError::ReferenceCrossed`].
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
                ("ratio of specific heats less 1", duct.gamma.unwrap_or(gamma) - 1.0),
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
        let references = ReferencePoint::all(&ducts)?;
        let one = ComplexDual::constant(C64::ONE);
        let basis = Basis::plain(&one, gamma, inlet, &ducts);
        let states: Vec<FlowState> = basis.after.iter().map(state_of).collect();
        basis.check()?;
        let losses = vec![[C64::ZERO; 2]; ducts.len()];
        let attached = Vec::new();
        Ok(Self {
            gamma,
            inlet,
            ducts,
            ends,
            entropy_waves: true,
            states,
            references,
            attached,
            losses,
            basis,
        })
    }

    /// The same chain with entropy waves that are lost in every duct, as shear and turbulence do to them in
    /// slow flows. Carried without loss they grow like e^{-sigma l/u} backwards in time, which for decaying
    /// modes in slow flows drowns the acoustics in rounding.
    #[must_use]
    pub fn without_entropy_waves(mut self) -> Self {
        self.entropy_waves = false;
        self
    }

    /// Whether entropy waves are carried through the ducts.
    #[must_use]
    pub fn carries_entropy_waves(&self) -> bool {
        self.entropy_waves
    }

    /// The same chain with other ends, upstream and downstream.
    #[must_use]
    pub fn with_ends(self, ends: [FlowEnd; 2]) -> Self {
        Self { ends, ..self }
    }

    /// The ends, upstream and downstream.
    #[must_use]
    pub fn ends(&self) -> &[FlowEnd; 2] {
        &self.ends
    }

    /// The ducts, from upstream to downstream.
    #[must_use]
    pub fn ducts(&self) -> &[FlowDuct] {
        &self.ducts
    }

    /// Ratios of specific heats of the ducts.
    #[must_use]
    pub fn gammas(&self) -> &[f64] {
        &self.basis.gammas
    }

    /// Mean states of the ducts.
    #[must_use]
    pub fn states(&self) -> &[FlowState] {
        &self.states
    }

    /// Time that sound needs through the chain and back, over two, s.
    #[must_use]
    pub fn travel_time(&self) -> f64 {
        let time = |((d, s), gamma): ((&FlowDuct, &FlowState), &f64)| {
            let c = s.sound_speed(*gamma);
            d.length * c / (c * c - s.velocity * s.velocity)
        };
        self.ducts.iter().zip(&self.states).zip(&self.basis.gammas).map(time).sum()
    }
}
