//! The adjoint of an eigenvalue with flow.
//!
//! As in [`crate::Network::sensitivities`] a row Lambda on (p, u, e) goes back through the chain. A velocity
//! that is taken elsewhere takes its own weight along: mu = Lambda x_1 k, what it adds at its place, enters
//! Lambda at the reference. For a loop mu is needed before it is known; Lambda is
//! affine in it, and mu = a + b mu follows.

use super::assembly::FlowChain;
use super::ducts::ActionKind;
use super::gate::Basis;
use super::passage::State;
use crate::error::NetworkError;
use crate::plane::newton::Root;
use rijke_numerics::C64;
use rijke_numerics::ComplexDual;

/// What weak devices do, in the order in which it is told of them.
pub(super) const EFFECTS: [ActionKind; 5] =
    [ActionKind::Mu, ActionKind::Mp, ActionKind::Eu, ActionKind::Ep, ActionKind::Branch];

pub(super) type Row = [C64; 3];

/// A mode as it passed, and the chain at its s.
pub(super) struct Passed<'a> {
    pub(super) chain: &'a FlowChain,
    /// The chain at this s, all constants.
    pub(super) basis: Basis<ComplexDual>,
    pub(super) s: ComplexDual,
    /// States behind every place, and at the outlet.
    pub(super) behind: Vec<State<ComplexDual>>,
    /// dF/ds, F without the factors of loops.
    slope: C64,
}

/// The way back.
pub(super) struct Back {
    /// Lambda at the downstream end of every duct.
    pub(super) ends: Vec<Row>,
    /// Weight of the velocity at every reference.
    pub(super) weights: Vec<C64>,
}

/// A constant.
pub(super) fn fixed(x: &State<ComplexDual>) -> State<ComplexDual> {
    x.map(|v| ComplexDual::constant(v.value))
}

pub(super) fn dot(row: &Row, x: &State<ComplexDual>) -> C64 {
    row[0] * x[0].value + row[1] * x[1].value + row[2] * x[2].value
}

/// row M of a linear map M.
pub(super) fn through(row: &Row, map: impl Fn(&State<ComplexDual>) -> State<ComplexDual>) -> Row {
    std::array::from_fn(|k| {
        let mut unit = [ComplexDual::constant(C64::ZERO); 3];
        unit[k] = ComplexDual::constant(C64::ONE);
        dot(row, &map(&unit))
    })
}

impl<'a> Passed<'a> {
    pub(super) fn new(
        chain: &'a FlowChain,
        basis: &Basis<ComplexDual>,
        root: &Root,
    ) -> Result<Self, NetworkError> {
        let s = ComplexDual { value: root.s, slope: C64::ONE };
        let mut behind = Vec::new();
        chain.sweep(basis, &s, |_, _, x| behind.push(*x));
        let slope = chain.finish(basis, &behind[chain.ducts.len()], &s).slope;
        if slope.is_finite() && slope != C64::ZERO {
            let (basis, s) = (basis.at_rest_in_s(), ComplexDual::constant(root.s));
            Ok(Self { chain, basis, s, behind, slope })
        } else {
            Err(NetworkError::NotFinite { s: root.s })
        }
    }

    /// The row of the eigenvalue.
    pub(super) fn eigenvalue(&self) -> Back {
        let (chain, n) = (self.chain, self.chain.ducts.len());
        let unit = |x: &State<ComplexDual>| [chain.finish(&self.basis, x, &self.s), self.s, self.s];
        let mut row = through(&[-self.slope.inv(), C64::ZERO, C64::ZERO], unit);
        let mut back =
            Back { ends: vec![[C64::ZERO; 3]; n], weights: vec![C64::ZERO; chain.references.len()] };
        for j in (0..n).rev() {
            back.ends[j] = row;
            for (e, _) in chain.references.iter().enumerate().filter(|(_, e)| e.duct == j && e.is_loop()) {
                back.weights[e] = self.loop_weight(e, row, &back.weights);
            }
            row = self.to_start(j, row, &back.weights);
            if j > 0 {
                for (e, point) in
                    chain.references.iter().enumerate().filter(|(_, e)| e.place == j && !e.is_loop())
                {
                    back.weights[e] = dot(&row, &chain.amplified(&self.basis, point, &self.s));
                }
                row = self.through_place(j, &row);
            }
        }
        back
    }

    /// From the downstream end of duct `j` to its upstream end.
    fn to_start(&self, j: usize, row: Row, weights: &[C64]) -> Row {
        let basis = &self.basis;
        let mut out = through(&row, |x| self.chain.pass(basis, j, x, &self.s));
        for (point, weight) in self.chain.references.iter().zip(weights).filter(|(e, _)| e.duct == j) {
            let unit =
                |x: &State<ComplexDual>| [self.chain.velocity_at(basis, point, x, &self.s), self.s, self.s];
            let added = through(&[*weight, C64::ZERO, C64::ZERO], unit);
            out = std::array::from_fn(|k| out[k] + added[k]);
        }
        out
    }

    fn through_place(&self, j: usize, row: &Row) -> Row {
        through(row, |x| self.chain.cross_alone(&self.basis, j, x, &self.s))
    }

    /// Weight of the velocity at the reference of a loop, from the row at the downstream end of the duct in
    /// which it lies.
    fn loop_weight(&self, index: usize, row: Row, weights: &[C64]) -> C64 {
        let point = &self.chain.references[index];
        let unit = self.chain.amplified(&self.basis, point, &self.s);
        let at_place = |mut row: Row, weights: &[C64]| {
            for j in (point.place..=point.duct).rev() {
                row = self.to_start(j, row, weights);
                if j > point.place {
                    row = self.through_place(j, &row);
                }
            }
            dot(&row, &unit)
        };
        let mut alone = vec![C64::ZERO; weights.len()];
        alone[index] = C64::ONE;
        at_place(row, weights) / (1.0 - at_place([C64::ZERO; 3], &alone))
    }
}
