//! Jets that belong together.

use super::order::{Order, packed};
use super::values::Jet;
use crate::C64;

/// The number of seeds and the order that a family of jets shares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JetSpace {
    seeds: usize,
    order: Order,
}

impl JetSpace {
    /// Jets in `seeds` variables up to `order`.
    #[must_use]
    pub fn new(seeds: usize, order: Order) -> Self {
        Self { seeds, order }
    }

    /// Number of variables.
    #[must_use]
    pub fn seeds(self) -> usize {
        self.seeds
    }

    /// Highest derivative carried.
    #[must_use]
    pub fn order(self) -> Order {
        self.order
    }

    /// A value that depends on no seed.
    #[must_use]
    pub fn constant(self, value: C64) -> Jet {
        let gradient = if self.order >= Order::First { self.seeds } else { 0 };
        let hessian = if self.order == Order::Second { packed(self.seeds, 0) } else { 0 };
        Jet { value, gradient: vec![C64::ZERO; gradient], hessian: vec![C64::ZERO; hessian] }
    }

    /// A real value that depends on no seed.
    #[must_use]
    pub fn real(self, value: f64) -> Jet {
        self.constant(C64::new(value, 0.0))
    }

    /// The variable number `index` itself. `index` must be below [`JetSpace::seeds`].
    #[must_use]
    pub fn seed(self, index: usize, value: C64) -> Jet {
        let mut jet = self.constant(value);
        if let Some(slope) = jet.gradient.get_mut(index) {
            *slope = C64::ONE;
        }
        jet
    }

    /// A jet of another space in this one: its seed number i becomes number `place(i)` here. Derivatives with
    /// respect to a seed without a place are left out.
    #[must_use]
    pub fn take(self, jet: &Jet, place: impl Fn(usize) -> Option<usize>) -> Jet {
        let mut taken = self.constant(jet.value);
        let places: Vec<Option<usize>> = (0..jet.gradient.len()).map(place).collect();
        for (i, row) in places.iter().enumerate() {
            let Some(row) = *row else { continue };
            if let Some(slope) = taken.gradient.get_mut(row) {
                *slope = jet.gradient[i];
            }
            for (j, column) in places[..=i].iter().enumerate() {
                let Some(column) = *column else { continue };
                if let Some(bend) = taken.hessian.get_mut(packed(row, column)) {
                    *bend = jet.hessian(i, j);
                }
            }
        }
        taken
    }
}
