//! One way to ask either chain, of gas at rest or with mean flow.

use crate::chain::coefficients::Coefficients;
use crate::chain::network::Network;
use crate::chain::workspace::Workspace;
use crate::error::NetworkError;
use crate::plane::modes::Modes;
use crate::plane::newton::{Newton, Root};
use crate::plane::region::Region;
use crate::respond::answer::{Places, Response};
use crate::sense::along::Station;
use crate::sense::budget::Budget;
use crate::sense::sensitivity::Sensitivities;
use crate::slot::Slot;
use rijke_numerics::{C64, Order};

/// A chain of ducts whose numbers laws of a caller can change: [`Network`], the gas at rest, or
/// [`crate::flow_chain::FlowChain`], with mean flow. Object-safe.
///
/// Places are numbered from the upstream end, 0, to the downstream end; place j lies before duct j. A mode is
/// a [`Root`], from [`Chain::solve`] or [`crate::Mode::root`]; every question about it takes this root and
/// the laws at which it was found.
///
/// ```
/// use rijke_network::{Chain, Constant, Network, Newton, Places, Segment, Slot, flow_chain::FlowChain};
/// use rijke_numerics::{C64, Order};
/// let mut tube = Network::cut_tube(Segment::new(1.0, 1.8e-3, 343.2, 1.2041), &[0.25])?;
/// tube.set(Slot::Upstream, C64::new(-0.99, 0.0))?;
/// tube.set(Slot::Downstream, C64::new(-0.99, 0.0))?;
/// let blown = FlowChain::of(&tube, 1.4, 0.5)?;
/// let chains: [&dyn Chain; 2] = [&tube, &blown];
/// let places = Places { at: vec![1], reference: 1 };
/// for chain in chains {
///     let mut work = Default::default();
///     let root = chain.solve(&Constant, C64::new(0.0, 1080.0), &Newton::default(), &mut work)?;
///     let s = chain.respond(&Constant, &root, &places, Order::Second, &mut work)?.s;
///     assert_eq!(s.value(), root.s);
///     assert!(chain.budget(&Constant, &root, &mut work)?.mismatch() < 1e-9);
/// }
/// # Ok::<(), rijke_network::NetworkError>(())
/// ```
pub trait Chain: std::fmt::Debug + Send + Sync {
    /// Number of ducts; the downstream end is the place of this number.
    fn count(&self) -> usize;

    /// Position of a place, m from the upstream end, without laws of lengths.
    fn position(&self, place: usize) -> f64;

    /// Time that sound needs to the end and back, over two, s. Modes lie about pi over this apart in angular
    /// frequency.
    fn travel_time(&self) -> f64;

    /// Adds `weight` times law number `law` to a slot. The laws themselves come with each question, as
    /// [`Coefficients`]. With mean flow, those of areas must not depend on s.
    ///
    /// # Errors
    /// [`NetworkError::Slot`] or [`NetworkError::NoDuct`] if there is none; with mean flow also
    /// [`NetworkError::ActionAtInlet`], [`NetworkError::SlotOfRest`], [`NetworkError::ChokedEnd`].
    fn attach(&mut self, slot: Slot, law: usize, weight: f64) -> Result<(), NetworkError>;

    /// The eigenvalue to which Newton's iteration from `guess` leads.
    ///
    /// # Errors
    /// As [`Network::solve`]; with mean flow also [`NetworkError::TooFast`], [`NetworkError::MeanFlowOfS`].
    fn solve(
        &self,
        laws: &dyn Coefficients,
        guess: C64,
        settings: &Newton,
        work: &mut Workspace,
    ) -> Result<Root, NetworkError>;

    /// Every mode in `region`, counted.
    ///
    /// # Errors
    /// As [`Network::modes`] and [`Chain::solve`].
    fn modes(
        &self,
        laws: &dyn Coefficients,
        region: &Region,
        work: &mut Workspace,
    ) -> Result<Modes, NetworkError>;

    /// Poles of F with their orders: all that lie in `region`, others may be among them.
    ///
    /// # Errors
    /// As [`Network::poles`].
    fn poles(&self, laws: &dyn Coefficients, region: &Region) -> Result<Vec<(C64, usize)>, NetworkError>;

    /// s and relative pressures with derivatives up to `order` in the parameters of the laws.
    ///
    /// # Errors
    /// As [`Network::respond`] and [`Chain::solve`].
    fn respond(
        &self,
        laws: &dyn Coefficients,
        root: &Root,
        places: &Places,
        order: Order,
        work: &mut Workspace,
    ) -> Result<Response, NetworkError>;

    /// The mode and what a small change anywhere does to s, at `samples` points of every duct, ends included
    /// (at least 2).
    ///
    /// # Errors
    /// As [`Network::along`] and [`Chain::solve`].
    fn along(
        &self,
        laws: &dyn Coefficients,
        root: &Root,
        samples: usize,
        work: &mut Workspace,
    ) -> Result<Vec<Station>, NetworkError>;

    /// Where the energy of the mode comes from and where it goes.
    ///
    /// # Errors
    /// As [`Chain::solve`].
    fn budget(
        &self,
        laws: &dyn Coefficients,
        root: &Root,
        work: &mut Workspace,
    ) -> Result<Budget, NetworkError>;

    /// How much relative errors of the chain's numbers are magnified in s: see [`Sensitivities::condition`].
    ///
    /// # Errors
    /// As [`Chain::solve`]; [`NetworkError::NotFinite`].
    fn condition(
        &self,
        laws: &dyn Coefficients,
        root: &Root,
        work: &mut Workspace,
    ) -> Result<f64, NetworkError>;
}

impl Chain for Network {
    fn count(&self) -> usize {
        self.segments.len()
    }

    fn position(&self, place: usize) -> f64 {
        Self::position(self, place)
    }

    fn travel_time(&self) -> f64 {
        Self::travel_time(self)
    }

    fn attach(&mut self, slot: Slot, law: usize, weight: f64) -> Result<(), NetworkError> {
        Self::attach(self, slot, law, weight)
    }

    fn solve(
        &self,
        laws: &dyn Coefficients,
        guess: C64,
        settings: &Newton,
        work: &mut Workspace,
    ) -> Result<Root, NetworkError> {
        Self::solve(self, laws, guess, settings, work)
    }

    fn modes(
        &self,
        laws: &dyn Coefficients,
        region: &Region,
        work: &mut Workspace,
    ) -> Result<Modes, NetworkError> {
        Self::modes(self, laws, region, work)
    }

    fn poles(&self, laws: &dyn Coefficients, region: &Region) -> Result<Vec<(C64, usize)>, NetworkError> {
        Self::poles(self, laws, region)
    }

    fn respond(
        &self,
        laws: &dyn Coefficients,
        root: &Root,
        places: &Places,
        order: Order,
        work: &mut Workspace,
    ) -> Result<Response, NetworkError> {
        Self::respond(self, laws, root, places, order, work)
    }

    fn along(
        &self,
        laws: &dyn Coefficients,
        root: &Root,
        samples: usize,
        work: &mut Workspace,
    ) -> Result<Vec<Station>, NetworkError> {
        Self::along(self, laws, root, samples, work)
    }

    fn budget(
        &self,
        laws: &dyn Coefficients,
        root: &Root,
        work: &mut Workspace,
    ) -> Result<Budget, NetworkError> {
        self.check(laws, root.s, &mut work.laws)?;
        Ok(Self::budget(self, laws, root, work))
    }

    fn condition(
        &self,
        laws: &dyn Coefficients,
        root: &Root,
        work: &mut Workspace,
    ) -> Result<f64, NetworkError> {
        let mut all = Sensitivities::default();
        // No pressure is asked for, so that a silent reference does not matter.
        let none = Places { at: Vec::new(), reference: 0 };
        self.sensitivities(laws, root, &none, &mut all, work)?;
        Ok(all.condition(self, root.s))
    }
}
