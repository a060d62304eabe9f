//! What a model at one operating point consists of.

use crate::assembly::Assembly;
use crate::shape::ShapeModel;
use rijke_formula::Formula;
use rijke_network::flow_chain::FlowChain;
use rijke_network::laws::Heard;
use rijke_network::{Network, Places};
use rijke_numerics::C64;

/// A network for one operating point, and the laws that fill its coefficients.
#[derive(Clone, Debug)]
pub struct PointModel<'a> {
    pub(crate) assembly: &'a Assembly,
    pub(super) id: String,
    pub(super) network: Network,
    /// Where lengths are unknown: the laws that stand in the place of `laws`.
    pub(super) shape: Option<ShapeModel<'a>>,
    /// The same ducts and laws in the mean flow, if the model has one and the gas flows here.
    pub(super) flowing: Option<FlowChain>,
    pub(super) laws: Vec<LawAt>,
    /// For each law, one for its surroundings alone, if it has been prepared.
    pub(super) prepared: Vec<Formula>,
    pub(super) surroundings: Vec<Vec<f64>>,
    /// Numbers of the laws, those of walls first, because what they lose is a name of the others.
    pub(super) order: Vec<usize>,
    /// Sources that answer to a velocity elsewhere, whose own laws follow `laws`.
    pub(super) heard: Heard,
    pub(super) places: Places,
    /// Places at which further effects are tried.
    pub(super) cuts: Vec<usize>,
    /// Place of the reference among the microphones that are predicted; none if there are no microphones.
    pub(super) reference: Option<usize>,
    pub(super) guess: C64,
    /// Distance between the modes of an open tube of this travel time, rad/s.
    pub(super) spacing: f64,
}

/// Effect number `effect` of candidate number `candidate`, evaluated in surroundings number `around`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LawAt {
    pub(super) candidate: usize,
    pub(super) effect: usize,
    pub(super) around: usize,
}
