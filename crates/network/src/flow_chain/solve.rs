//! Modes of a chain with flow: the one nearest a guess, and all in a region.

use super::assembly::FlowChain;
use super::ducts::{Action, FlowEnd, Reference};
use crate::error::NetworkError;
use crate::plane::modes::Modes;
use crate::plane::newton::{Newton, Root, iterate};
use crate::plane::poles::PolesByPlace;
use crate::plane::region::Region;
use crate::plane::zeros::zeros;
use rijke_numerics::C64;
use rijke_numerics::ComplexDual;

/// Largest power of e by which entropy waves may grow through the chain: at e^709 numbers overflow.
const MOST_GROWTH: f64 = 600.0;

/// Places at which velocities are taken that are one, over the length of the chain.
const ONE_PLACE: f64 = 1e-7;

impl FlowChain {
    /// Every mode in `region`, counted as by [`crate::Network::modes`].
    ///
    /// # Errors
    /// As [`crate::Network::modes`].
    pub fn modes(&self, region: &Region) -> Result<Modes, NetworkError> {
        region.check()?;
        self.bound_entropy_waves(region)?;
        let step = 0.25 * std::f64::consts::PI / self.travel_time();
        let poles = self.poles(&region.widened(4.0 * step))?;
        let inside = poles.iter().filter(|p| region.contains(p.0)).map(|p| p.1).sum();
        zeros(|s| self.characteristic(s), region, step, poles, inside)
    }

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
    pub fn poles(&self, region: &Region) -> Result<Vec<(C64, usize)>, NetworkError> {
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

    /// The eigenvalue to which Newton's iteration from `guess` leads.
    ///
    /// # Errors
    /// As [`crate::Network::solve`].
    pub fn solve(&self, guess: C64, settings: &Newton) -> Result<Root, NetworkError> {
        let spacing = std::f64::consts::PI / self.travel_time();
        iterate(guess, spacing, settings, |s| {
            self.sweep(&self.basis, &ComplexDual { value: s, slope: C64::ONE }, |_, _, _| ())
        })
    }

    /// F(s) = g - R_d f at the outlet for g = 1 and no entropy wave at the inlet, and dF/ds.
    #[must_use]
    pub fn characteristic(&self, s: C64) -> [C64; 2] {
        let f = self.sweep(&self.basis, &ComplexDual { value: s, slope: C64::ONE }, |_, _, _| ());
        [f.value, f.slope]
    }
}
