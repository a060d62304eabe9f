//! What searches for modes of a chain with flow must know: F, its poles, and where entropy waves overflow.

use super::assembly::FlowChain;
use super::ducts::{Action, FlowEnd, Reference};
use crate::error::NetworkError;
use crate::plane::poles::PolesByPlace;
use crate::plane::region::Region;
use rijke_numerics::{C64, ComplexDual};

/// Largest power of e by which entropy waves may grow through the chain: at e^709 numbers overflow.
const MOST_GROWTH: f64 = 600.0;

/// Places at which velocities are taken that are one, over the length of the chain.
const ONE_PLACE: f64 = 1e-7;

impl FlowChain {
    /// Refuses a region in which entropy waves are no numbers.
    ///
    /// # Errors
    /// [`NetworkError::EntropyWaves`] where e^{-sigma l/U} overflows in the region.
    pub(super) fn bound_entropy_waves(&self, region: &Region) -> Result<(), NetworkError> {
        let slow: f64 = self.ducts.iter().zip(&self.states).map(|(d, state)| d.length / state.velocity).sum();
        let sigma = region.sigma[0];
        let exponent = -sigma * slow;
        if self.entropy_waves && exponent > MOST_GROWTH {
            return Err(NetworkError::EntropyWaves { sigma, exponent, least: -MOST_GROWTH / slow });
        }
        Ok(())
    }

    /// Poles of the laws that act, with their orders: all that lie in `region`, others may be among them.
    ///
    /// # Errors
    /// As [`crate::laws::Law::poles_in`].
    pub(super) fn own_poles(&self, region: &Region) -> Result<Vec<(C64, usize)>, NetworkError> {
        let mut all = Vec::new();
        for end in &self.ends {
            if let FlowEnd::Reflection(law) = end {
                all.extend(law.poles_in(region)?);
            }
        }
        let total: f64 = self.ducts.iter().map(|d| d.length).sum();
        let mut poles = PolesByPlace::default();
        let (mut x, mut number) = (0.0, 0);
        for (place, duct) in self.ducts.iter().enumerate() {
            for Action { effect, law, reference } in &duct.actions {
                let heard = match reference {
                    _ if !effect.of_velocity() => None,
                    Reference::Upstream(distance) => Some(x - distance),
                    Reference::Downstream(distance) => Some(x + distance),
                };
                // What answers to one velocity is of rank one, wherever it acts.
                let is_here = |other: &(usize, Option<f64>)| {
                    let one = heard.zip(other.1).is_some_and(|(a, b)| (a - b).abs() < ONE_PLACE * total);
                    other.0 == place || one
                };
                for pole in law.poles_in(region)? {
                    poles.add(pole, number, is_here, (place, heard));
                }
                number += 1;
            }
            x += duct.length;
        }
        all.extend(poles.all());
        Ok(all)
    }

    /// F(s) = g - R_d f at the outlet for g = 1 and no entropy wave at the inlet, and dF/ds.
    #[must_use]
    pub fn characteristic(&self, s: C64) -> [C64; 2] {
        let f = self.sweep(&self.basis, &ComplexDual { value: s, slope: C64::ONE }, |_, _, _| ());
        [f.value, f.slope]
    }
}
