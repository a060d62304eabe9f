//! The numbers of a prediction: s, then the relative pressures but the reference's, which is 1 by definition; real and
//! imaginary parts in turn. The order of `rijke_rig::Ping::vector`.

use crate::PointModel;
use rijke_network::Response;
use rijke_numerics::{C64, Jet};

impl PointModel<'_> {
    /// The complex numbers that a response of this model predicts: s, then the relative pressures but the reference's.
    pub fn numbers<'r>(&self, response: &'r Response) -> impl Iterator<Item = &'r Jet> {
        let reference = self.reference;
        let others = response.pressures.iter().enumerate().filter(move |(m, _)| *m != reference);
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
