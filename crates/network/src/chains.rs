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
///     assert!(chain.balance(&Constant, &root, &mut work)?.mismatch() < 1e-9);
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
    fn balance(
        &self,
        laws: &dyn Coefficients,
        root: &Root,
        work: &mut Workspace,
    ) -> Result<Balance, NetworkError>;

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

/// Mean power by mechanism over the energy of a mode, 1/s; positive feeds the mode. Half of each is its share
/// of the growth rate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Balance {
    /// 2 sigma, what the others add up to.
    pub growth: f64,
    /// Through the upstream end, convection included.
    pub upstream: f64,
    /// Through the downstream end.
    pub downstream: f64,
    /// Viscous losses of the ducts.
    pub viscous: f64,
    /// Thermal losses of the ducts.
    pub thermal: f64,
    /// What the mean flow takes where nothing acts; 0 at rest.
    pub mean_flow: f64,
    /// At places where something acts.
    pub places: Vec<Power>,
}

/// Mean power over energy at one place, 1/s.
#[derive(Clone, Debug, PartialEq)]
pub struct Power {
    /// The place.
    pub place: usize,
    /// All of it.
    pub power: f64,
    /// The parts that laws of the caller have in it; the rest is constant feedback, actions and mean heat of
    /// the chain itself. Products of two laws are halved between them.
    pub laws: Vec<(usize, f64)>,
}

impl Balance {
    /// Sum of all entries minus 2 sigma, relative to the sum of their moduli: zero but for rounding at an
    /// eigenvalue, and only there.
    #[must_use]
    pub fn mismatch(&self) -> f64 {
        let parts = [self.upstream, self.downstream, self.viscous, self.thermal, self.mean_flow];
        let all = parts.into_iter().chain(self.places.iter().map(|p| p.power));
        let (sum, size) = all.fold((0.0, 0.0), |(sum, size), x| (sum + x, size + f64::abs(x)));
        let scale = size.max(self.growth.abs());
        if scale > 0.0 { (sum - self.growth).abs() / scale } else { 0.0 }
    }
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

    fn balance(
        &self,
        laws: &dyn Coefficients,
        root: &Root,
        work: &mut Workspace,
    ) -> Result<Balance, NetworkError> {
        self.check(laws, root.s, &mut work.laws)?;
        let budget = self.budget(laws, root, work);
        let place = |e: crate::sense::budget::Exchange| Power {
            place: e.place,
            power: e.power.iter().sum(),
            laws: e.laws,
        };
        Ok(Balance {
            growth: budget.growth,
            upstream: budget.upstream,
            downstream: budget.downstream,
            viscous: budget.viscous,
            thermal: budget.thermal,
            mean_flow: 0.0,
            places: budget.places.into_iter().map(place).collect(),
        })
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
