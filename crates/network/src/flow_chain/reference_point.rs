//! Actions that answer to the velocity elsewhere, upstream or downstream, through any ducts and places.
//!
//! Upstream, the velocity is known when the state reaches the place. Downstream it is not: with the state
//! behind the place x_0 + k v x_1 (x_1 what a unit amount of the effect adds) and the velocities v_0 and v_1
//! that x_0 and x_1 make at the reference, v = v_0/(1 - k v_1). F is multiplied by 1 - k v_1, so that a loop
//! brings it no poles.

use super::ducts::{Action, FlowDuct, Reference};
use super::gate::Basis;
use super::number::Number;
use crate::error::NetworkError;

/// An action that answers to the velocity elsewhere.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ReferencePoint {
    /// The place, and which of its actions.
    pub(super) place: usize,
    pub(super) action: usize,
    /// The duct in which its reference lies.
    pub(super) duct: usize,
    reference: Reference,
}

impl Action {
    fn is_remote(&self) -> bool {
        self.effect.of_velocity() && self.reference != Reference::Upstream(0.0)
    }
}

impl ReferencePoint {
    pub(super) fn all(ducts: &[FlowDuct]) -> Result<Vec<Self>, NetworkError> {
        let mut references: Vec<Self> = Vec::new();
        for (place, duct) in ducts.iter().enumerate() {
            for (action, of) in duct.actions.iter().enumerate().filter(|(_, a)| a.is_remote()) {
                let reference = of.reference;
                let (mut way, distance): (Vec<usize>, f64) = match reference {
                    Reference::Upstream(d) => ((0..place).rev().collect(), d),
                    Reference::Downstream(d) => ((place..ducts.len()).collect(), d),
                };
                let length: f64 = way.iter().map(|&i| ducts[i].length).sum();
                if !(0.0..=length * (1.0 + 1e-9)).contains(&distance) {
                    return Err(NetworkError::Outside { x: distance, length });
                }
                let mut left = distance - 1e-9 * length;
                way.retain(|&i| {
                    let reached = left > 0.0;
                    left -= ducts[i].length;
                    reached
                });
                let duct = way.last().copied().unwrap_or(place);
                references.push(Self { place, action, duct, reference });
            }
        }
        for loops in references.iter().filter(|e| e.is_loop()) {
            let between = loops.place..=loops.duct;
            if let Some(other) = references.iter().find(|e| *e != loops && between.contains(&e.place)) {
                return Err(NetworkError::ReferenceCrossed { place: loops.place, other: other.place });
            }
        }
        Ok(references)
    }

    pub(super) fn is_loop(&self) -> bool {
        matches!(self.reference, Reference::Downstream(_))
    }

    /// Where it lies: m from the upstream end of its duct.
    pub(super) fn offset<T: Number>(&self, basis: &Basis<T>) -> T {
        let sum = |range: std::ops::Range<usize>| {
            basis.length[range].iter().fold(basis.length[0].real(0.0), |sum, l| sum + l.clone())
        };
        match self.reference {
            Reference::Upstream(d) => sum(self.duct..self.place) - basis.length[0].real(d),
            Reference::Downstream(d) => basis.length[0].real(d) - sum(self.place..self.duct),
        }
    }
}
