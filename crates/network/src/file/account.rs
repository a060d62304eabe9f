//! What is asked of a network that was read from a file, whether its gas is at rest or flows: modes, poles,
//! where the growth rate of a mode comes from, and what small changes along it would do.

use super::build::Built;
use crate::chain::workspace::Workspace;
use crate::chains::Chain;
use crate::error::NetworkError;
use crate::flow_chain::FlowChain;
use crate::plane::modes::{Mode, Modes};
use crate::plane::newton::{Newton, Root};
use crate::plane::region::Region;
use crate::sense::along::Station;
use rijke_numerics::C64;

/// Points to ask of each of `ducts` ducts for a smooth curve: about 1200 along the whole tube, at most a
/// twentieth of them in one.
#[must_use]
pub fn samples_of_each(ducts: usize) -> usize {
    const POINTS: usize = 1200;
    (POINTS / ducts.max(1)).clamp(2, POINTS / 20) + 1
}

/// Where the growth rate of a mode comes from. The shares add up to it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Account {
    /// How much relative errors of the network's numbers are magnified in s: see
    /// [`crate::Sensitivities::condition`].
    pub condition: f64,
    /// Share of the upstream end, 1/s.
    pub upstream: f64,
    /// Share of the downstream end, 1/s.
    pub downstream: f64,
    /// Share of viscous losses at walls, 1/s.
    pub viscous: f64,
    /// Share of thermal losses at walls, 1/s.
    pub thermal: f64,
    /// Shares of elements by name, 1/s, in the order of the chain; with mean flow, what it takes comes last.
    pub elements: Vec<(String, f64)>,
}

impl Account {
    /// The account of a mode of a chain with mean flow, of which `names` say what acts at places.
    ///
    /// # Errors
    /// [`NetworkError::NotFinite`].
    pub fn with_flow(
        chain: &FlowChain,
        names: &[(usize, String)],
        root: &Root,
    ) -> Result<Self, NetworkError> {
        let budget = chain.budget(root);
        let shares = [budget.upstream, budget.downstream, budget.viscous, budget.thermal];
        let mut account = Self::of_shares(shares, chain.condition(root)?);
        for (place, power) in &budget.places {
            let here = names.iter().filter(|(p, _)| p == place).map(|(_, name)| name.as_str());
            let name = here.collect::<Vec<_>>().join(" + ");
            account.add(if name.is_empty() { "heat and lumped losses" } else { &name }, 0.5 * power);
        }
        account.add("mean flow", 0.5 * budget.mean_flow);
        Ok(account)
    }

    /// Of powers over energy, which are twice the shares.
    fn of_shares(powers: [f64; 4], condition: f64) -> Self {
        let [upstream, downstream, viscous, thermal] = powers.map(|power| 0.5 * power);
        Self { condition, upstream, downstream, viscous, thermal, elements: Vec::new() }
    }

    fn add(&mut self, name: &str, share: f64) {
        match self.elements.iter_mut().find(|(known, _)| known == name) {
            Some((_, sum)) => *sum += share,
            None => self.elements.push((name.to_owned(), share)),
        }
    }
}

impl Built {
    /// Every mode in `region`, counted.
    ///
    /// # Errors
    /// As [`crate::Network::modes`].
    pub fn modes(&self, region: &Region) -> Result<Modes, NetworkError> {
        match &self.flow {
            Some(chain) => chain.modes(region),
            None => self.network.modes(&self.laws, region, &mut Workspace::default()),
        }
    }

    /// The eigenvalue to which Newton's iteration from `guess` leads.
    ///
    /// # Errors
    /// As [`crate::Network::solve`].
    pub fn solve(&self, guess: C64, settings: &Newton, work: &mut Workspace) -> Result<Root, NetworkError> {
        match &self.flow {
            Some(chain) => chain.solve(guess, settings),
            None => self.network.solve(&self.laws, guess, settings, work),
        }
    }

    /// F(s) and dF/ds of the function whose zeros are the eigenvalues.
    #[must_use]
    pub fn characteristic(&self, s: C64, work: &mut Workspace) -> [C64; 2] {
        match &self.flow {
            Some(chain) => chain.characteristic(s),
            None => self.network.characteristic_function(&self.laws, s, work),
        }
    }

    /// Poles of laws within `region`, which are not modes.
    ///
    /// # Errors
    /// As [`crate::Network::poles`].
    pub fn poles(&self, region: &Region) -> Result<Vec<C64>, NetworkError> {
        let poles = match &self.flow {
            Some(chain) => chain.poles(region),
            None => self.network.poles(&self.laws, region),
        }?;
        Ok(poles.into_iter().map(|p| p.0).filter(|s| region.contains(*s)).collect())
    }

    /// Where the growth rate of a mode comes from.
    ///
    /// # Errors
    /// [`NetworkError::NotFinite`].
    pub fn account(&self, mode: &Mode) -> Result<Account, NetworkError> {
        let root = mode.root();
        if let Some(chain) = &self.flow {
            return Account::with_flow(chain, &self.places, &root);
        }
        let mut work = Workspace::default();
        let budget = self.network.budget(&self.laws, &root, &mut work);
        let shares = [budget.upstream, budget.downstream, budget.viscous, budget.thermal];
        let condition = Chain::condition(&self.network, &self.laws, &root, &mut work)?;
        let mut account = Account::of_shares(shares, condition);
        for (law, power) in budget.places.iter().flat_map(|exchange| &exchange.laws) {
            account.add(&self.actors[*law], 0.5 * power);
        }
        Ok(account)
    }

    /// The mode at `root` and what a small change anywhere does to it, at `samples` points of every duct.
    ///
    /// # Errors
    /// As [`crate::Network::along`].
    pub fn along(&self, root: &Root, samples: usize) -> Result<Vec<Station>, NetworkError> {
        match &self.flow {
            Some(chain) => chain.along(root, samples),
            None => self.network.along(&self.laws, root, samples, &mut Workspace::default()),
        }
    }

    /// Number of ducts along which [`Built::along`] goes.
    #[must_use]
    pub fn ducts(&self) -> usize {
        self.flow.as_ref().map_or(self.network.segments().len(), |chain| chain.ducts().len())
    }
}
