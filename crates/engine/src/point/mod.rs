//! The model at one operating point: a network whose coefficients are laws. Must not know what was measured.

mod attach;
mod cuts;
mod doubled;
mod fill;
#[cfg(test)]
pub(crate) mod given;
mod hear;
mod law;
mod model;
mod nearer;
mod poles;
mod probe;
mod spread;
mod tables;
mod together;
mod zero;

pub(crate) use poles::{Acting, poles};
pub(crate) use probe::Probed;
pub(crate) use together::respond_together;

use crate::EngineError;
use crate::assembly::Assembly;
use crate::conditions::Conditions;
use crate::shape::{Moving, ShapeModel};
use fill::Filled;
use model::LawAt;
pub use model::PointModel;
use rijke_network::flow_chain::FlowChain;
use rijke_network::laws::Heard;
use rijke_network::{Chain, Coefficients, Network, NetworkError, Newton, Places, Response, Root, Workspace};
use rijke_numerics::{C64, Jet, Order};
use rijke_study::MeanFlow;
use rijke_study::names::{MACH, MASS_FLUX, VELOCITY};
pub use tables::BeyondTable;

/// The estimate of the error of an eigenvalue, relative to |s|, that ends its search. The estimate is that of
/// the last term taken, so the error itself is smaller by the distance of the guess over that of the modes:
/// near rounding.
const EIGENVALUE_TOLERANCE: f64 = 1e-11;

/// Beside poles of laws a nearer eigenvalue is looked for if the one found lies farther from the guess than
/// this share of the distance between modes.
const NEAR: f64 = 0.02;

impl<'a> PointModel<'a> {
    /// Lays out the network. `microphones` are those predicted, in order, the reference among them; none for
    /// the eigenvalue alone.
    ///
    /// # Errors
    /// [`EngineError::Network`] for a geometry that is impossible.
    pub fn new(
        assembly: &'a Assembly,
        conditions: &Conditions,
        microphones: &[usize],
    ) -> Result<Self, EngineError> {
        Self::with_cuts(assembly, conditions, microphones, &[])
    }

    /// The same with places where further effects can be tried, m.
    ///
    /// # Errors
    /// As [`PointModel::new`].
    pub(crate) fn with_cuts(
        assembly: &'a Assembly,
        conditions: &Conditions,
        microphones: &[usize],
        further: &[f64],
    ) -> Result<Self, EngineError> {
        let fail = |source| EngineError::Network { point: conditions.id.clone(), source };
        let layout = &conditions.layout;
        assembly.waves_for(0, layout)?;
        let reference = microphones.iter().position(|m| *m == assembly.rig.microphones.reference);
        let heard: Vec<f64> = microphones.iter().map(|&m| layout.microphones[m]).collect();
        // Where nothing listens, the mode is scaled by the pressure at a place that is no simple fraction of
        // the length.
        let elsewhere = 0.3719 * layout.length;
        let at_reference = reference.map_or(elsewhere, |k| heard[k]);
        let instruments = || heard.iter().copied().chain([at_reference]).chain(further.iter().copied());
        let travel = conditions.base.travel_time(0.0, layout.length);
        let guess = C64::new(-10.0, std::f64::consts::PI / travel);
        let bare = |network, shape, places, cuts| Self {
            assembly,
            id: conditions.id.clone(),
            network,
            shape,
            flowing: None,
            laws: Vec::new(),
            prepared: Vec::new(),
            surroundings: Vec::new(),
            order: Vec::new(),
            heard: Heard::default(),
            places,
            cuts,
            reference,
            guess,
            spacing: std::f64::consts::PI / travel,
        };
        if assembly.rig.is_of_unknown_shape() {
            let shape = ShapeModel::new(assembly, conditions, &instruments().collect::<Vec<_>>())?;
            let (network, all) = (shape.network.clone(), &shape.microphones);
            let places = Places { at: all[..heard.len()].to_vec(), reference: all[heard.len()] };
            let cuts = all[heard.len() + 1..].to_vec();
            return Ok(bare(network, Some(shape), places, cuts));
        }
        let stretches = cuts::segments(conditions, &cuts::all(assembly, conditions, instruments()));
        let network = Network::new(stretches.iter().map(|s| s.segment).collect()).map_err(fail)?;
        let places = Places {
            at: heard.iter().map(|x| network.place_at(*x)).collect::<Result<_, _>>().map_err(fail)?,
            reference: network.place_at(at_reference).map_err(fail)?,
        };
        let found = further.iter().map(|x| network.place_at(*x)).collect::<Result<_, _>>().map_err(fail)?;
        let mut model = bare(network, None, places, found);
        let sources = model.attach(conditions, &stretches).map_err(fail)?;
        model.flows_forwards(conditions)?;
        model.complete_walls();
        model.forget_unused();
        model.listen(conditions, &stretches, sources)?;
        model.flowing = model.in_flow(conditions, &stretches).map_err(fail)?;
        if model.flowing.is_some() && assembly.rig.is_choked {
            return Err(EngineError::Choked { point: conditions.id.clone() });
        }
        Ok(model)
    }

    /// The same model with the root search started from `guess` (say, the measured s).
    #[must_use]
    pub fn starting_from(self, guess: C64) -> Self {
        Self { guess, ..self }
    }

    /// The same model, faster from the second call on: arithmetic that no parameter enters is done now.
    #[must_use]
    pub fn prepared(mut self) -> Self {
        let law = |at: &LawAt| self.effect(at).law.at(&self.surroundings[at.around]);
        self.prepared = self.laws.iter().map(law).collect();
        self
    }

    /// Name of the operating point.
    #[must_use]
    pub fn id(&self) -> &str {
        &self.id
    }

    /// The chain that is solved.
    pub(crate) fn chain(&self) -> &dyn Chain {
        match &self.flowing {
            Some(flowing) => flowing,
            None => &self.network,
        }
    }

    /// Refuses a flow from downstream to upstream where a law names the velocity, or waves are those of the
    /// flow: velocities are those of a flow from upstream.
    fn flows_forwards(&self, conditions: &Conditions) -> Result<(), EngineError> {
        if conditions.base.mass_flow >= 0.0 {
            return Ok(());
        }
        let velocity = conditions.around(0.0)[VELOCITY];
        let names_it =
            |law: &&LawAt| [VELOCITY, MACH, MASS_FLUX].iter().any(|name| self.effect(law).law.uses(*name));
        let what = match self.laws.iter().find(names_it) {
            Some(law) => {
                let effect = self.effect(law);
                format!(
                    "a law at {} names the velocity, for which it takes one from upstream",
                    effect.place_text
                )
            }
            None if self.assembly.mean_flow().is_some() => {
                "`mean_flow` is of a flow from upstream".to_owned()
            }
            None => return Ok(()),
        };
        Err(EngineError::Backwards { point: self.id.clone(), velocity, what })
    }

    /// The network in the mean flow of the base state; none for a model of gas at rest, or where nothing
    /// flows.
    fn in_flow(
        &self,
        conditions: &Conditions,
        pieces: &[cuts::Piece],
    ) -> Result<Option<FlowChain>, NetworkError> {
        let (Some(kind), Some(first)) = (self.assembly.mean_flow(), pieces.first()) else { return Ok(None) };
        let velocity = conditions.base.mass_flow / (first.segment.density * first.segment.area);
        if velocity <= 0.0 {
            return Ok(None);
        }
        let chain = FlowChain::of(&self.network, first.gas.gamma, velocity)?;
        Ok(Some(match kind {
            MeanFlow::Full => chain,
            MeanFlow::WithoutEntropy => chain.without_entropy_waves(),
        }))
    }

    /// The eigenvalue and the relative pressures with their derivatives in the free parameters.
    ///
    /// # Errors
    /// [`EngineError::Count`], or [`EngineError::Network`] when there is no eigenvalue near the guess.
    pub fn respond(
        &self,
        values: &[f64],
        order: Order,
        work: &mut Workspace,
    ) -> Result<Response, EngineError> {
        self.respond_near(values, self.guess, order, work)
    }

    /// About how far modes lie from each other, rad/s.
    pub(crate) fn spacing(&self) -> f64 {
        self.spacing
    }

    /// As [`PointModel::respond`], of the mode near `guess`.
    pub(crate) fn respond_near(
        &self,
        values: &[f64],
        guess: C64,
        order: Order,
        work: &mut Workspace,
    ) -> Result<Response, EngineError> {
        let (filled, root) = self.solve(values, guess, work)?;
        let found = self.chain().respond(&*filled, &root, &self.places, order, work);
        found.map_err(|source| self.no_answer(source))
    }

    pub(crate) fn filled<'m>(
        &'m self,
        values: &'m [f64],
    ) -> Result<Box<dyn Coefficients + Sync + 'm>, EngineError> {
        let expected = self.assembly.parameters().len();
        if values.len() != expected {
            return Err(EngineError::Count { expected, found: values.len() });
        }
        match &self.shape {
            Some(shape) => Ok(Box::new(Moving::new(shape, values, &self.id)?)),
            None => Ok(Box::new(Filled::new(self, values))),
        }
    }

    /// Whether lengths, areas and temperatures are those of a rig at these values of the parameters.
    pub(crate) fn is_possible(&self, values: &[f64]) -> bool {
        self.filled(values).is_ok()
    }

    fn solve<'m>(
        &'m self,
        values: &'m [f64],
        guess: C64,
        work: &mut Workspace,
    ) -> Result<(Box<dyn Coefficients + Sync + 'm>, Root), EngineError> {
        let filled = self.filled(values)?;
        let settings = Newton { tolerance: EIGENVALUE_TOLERANCE, ..Newton::default() };
        let mut search = |from: C64| self.chain().solve(&*filled, from, &settings, work);
        let mut root = search(guess);
        let apart = root.as_ref().map_or(self.spacing, |root| (root.s - guess).norm());
        if apart > NEAR * self.spacing
            && let Some(nearer) = self.behind_a_pole(&*filled, guess, apart.min(self.spacing))
        {
            root = search(nearer).or(root);
        }
        root.map(|root| (filled, root)).map_err(|source| self.no_answer(source))
    }

    pub(crate) fn no_answer(&self, source: NetworkError) -> EngineError {
        EngineError::Network { point: self.id.clone(), source }
    }

    /// The complex numbers that a response of this model predicts: s, then the relative pressures but the
    /// reference's.
    pub(crate) fn numbers<'r>(&self, response: &'r Response) -> impl Iterator<Item = &'r Jet> {
        let reference = self.reference;
        let others = response.pressures.iter().enumerate().filter(move |(m, _)| Some(*m) != reference);
        std::iter::once(&response.s).chain(others.map(|(_, p)| p))
    }

    /// The derivative of the prediction with respect to free parameter `k`, of a response of first order.
    pub(crate) fn slope(&self, response: &Response, k: usize) -> Vec<f64> {
        parts(self.numbers(response).map(|z| z.gradient()[k]))
    }
}

/// Real and imaginary parts in turn.
pub(crate) fn parts(numbers: impl Iterator<Item = C64>) -> Vec<f64> {
    numbers.flat_map(|z| [z.re, z.im]).collect()
}
