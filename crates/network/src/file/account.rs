//! What is asked of a network that was read from a file, whether its gas is at rest or flows: modes, poles,
//! where the growth rate of a mode comes from, and what small changes along it would do.

use super::build::Built;
use crate::chain::coefficients::{Coefficients, Constant};
use crate::chain::workspace::Workspace;
use crate::chains::Chain;
use crate::error::NetworkError;
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

/// Whose the powers at places are.
#[derive(Clone, Copy, Debug)]
pub enum Actors<'a> {
    /// Of laws: by law, who it is.
    OfLaws(&'a [String]),
    /// Of what acts at places of a chain with mean flow: place and name.
    AtPlaces(&'a [(usize, String)]),
}

impl Account {
    /// The account of a mode of a chain with its laws.
    ///
    /// # Errors
    /// As [`Chain::budget`] and [`Chain::condition`].
    pub fn of(
        chain: &dyn Chain,
        laws: &dyn Coefficients,
        actors: Actors<'_>,
        root: &Root,
    ) -> Result<Self, NetworkError> {
        let mut work = Workspace::default();
        let budget = chain.budget(laws, root, &mut work)?;
        let condition = chain.condition(laws, root, &mut work)?;
        let [upstream, downstream, viscous, thermal] =
            [budget.upstream, budget.downstream, budget.viscous, budget.thermal].map(|power| 0.5 * power);
        let mut account = Self { condition, upstream, downstream, viscous, thermal, elements: Vec::new() };
        match actors {
            Actors::OfLaws(names) => {
                for (law, power) in budget.places.iter().flat_map(|at| &at.laws) {
                    account.add(&names[*law], 0.5 * power);
                }
            }
            Actors::AtPlaces(names) => {
                for at in &budget.places {
                    let here = names.iter().filter(|(place, _)| *place == at.place);
                    let name = here.map(|(_, name)| name.as_str()).collect::<Vec<_>>().join(" + ");
                    let name = if name.is_empty() { "heat and lumped losses" } else { &name };
                    account.add(name, 0.5 * at.power);
                }
                account.add("mean flow", 0.5 * budget.mean_flow);
            }
        }
        Ok(account)
    }

    fn add(&mut self, name: &str, share: f64) {
        match self.elements.iter_mut().find(|(known, _)| known == name) {
            Some((_, sum)) => *sum += share,
            None => self.elements.push((name.to_owned(), share)),
        }
    }
}

impl Built {
    /// The chain that is asked, with its mean flow if it has one, and its laws.
    #[must_use]
    pub fn chain(&self) -> (&dyn Chain, &dyn Coefficients) {
        match &self.flow {
            Some(flow) => (flow, &Constant),
            None => (&self.network, &self.laws),
        }
    }

    /// Every mode in `region`, counted.
    ///
    /// # Errors
    /// As [`Chain::modes`].
    pub fn modes(&self, region: &Region) -> Result<Modes, NetworkError> {
        let (chain, laws) = self.chain();
        chain.modes(laws, region, &mut Workspace::default())
    }

    /// The eigenvalue to which Newton's iteration from `guess` leads.
    ///
    /// # Errors
    /// As [`Chain::solve`].
    pub fn solve(&self, guess: C64, settings: &Newton, work: &mut Workspace) -> Result<Root, NetworkError> {
        let (chain, laws) = self.chain();
        chain.solve(laws, guess, settings, work)
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
    /// As [`Chain::poles`].
    pub fn poles(&self, region: &Region) -> Result<Vec<C64>, NetworkError> {
        let (chain, laws) = self.chain();
        let poles = chain.poles(laws, region)?.into_iter().map(|p| p.0);
        Ok(poles.filter(|s| region.contains(*s)).collect())
    }

    /// Where the growth rate of a mode comes from.
    ///
    /// # Errors
    /// As [`Account::of`].
    pub fn account(&self, mode: &Mode) -> Result<Account, NetworkError> {
        let (chain, laws) = self.chain();
        let at_places = self.flow.as_ref().map(|_| Actors::AtPlaces(&self.places));
        Account::of(chain, laws, at_places.unwrap_or(Actors::OfLaws(&self.actors)), &mode.root())
    }

    /// The mode at `root` and what a small change anywhere does to it, at `samples` points of every duct.
    ///
    /// # Errors
    /// As [`Chain::along`].
    pub fn along(&self, root: &Root, samples: usize) -> Result<Vec<Station>, NetworkError> {
        let (chain, laws) = self.chain();
        chain.along(laws, root, samples, &mut Workspace::default())
    }

    /// Number of ducts along which [`Built::along`] goes.
    #[must_use]
    pub fn ducts(&self) -> usize {
        self.chain().0.count()
    }
}
