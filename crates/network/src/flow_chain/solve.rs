//! Modes of a chain with flow: the one nearest a guess, and all in a region.

use super::assembly::FlowChain;
use super::ducts::FlowEnd;
use crate::error::NetworkError;
use crate::plane::modes::Modes;
use crate::plane::newton::{Newton, Root, iterate};
use crate::plane::region::Region;
use crate::plane::zeros::zeros;
use rijke_numerics::C64;
use rijke_numerics::ComplexDual;

impl FlowChain {
    /// Every mode in `region`, counted as by [`crate::Network::modes`].
    ///
    /// # Errors
    /// As [`crate::Network::modes`].
    pub fn modes(&self, region: &Region) -> Result<Modes, NetworkError> {
        region.check()?;
        let step = 0.25 * std::f64::consts::PI / self.travel_time();
        let poles = self.poles(&region.widened(4.0 * step))?;
        let inside = poles.iter().filter(|p| region.contains(p.0)).map(|p| p.1).sum();
        zeros(|s| self.characteristic(s), region, step, poles, inside)
    }

    /// Poles of the laws that act, with their orders: all that lie in `region`, others may be among them.
    ///
    /// # Errors
    /// As [`crate::laws::Law::poles_in`].
    pub fn poles(&self, region: &Region) -> Result<Vec<(C64, usize)>, NetworkError> {
        let reflections = self.ends.iter().filter_map(|end| match end {
            FlowEnd::Reflection(law) => Some(law),
            FlowEnd::Choked => None,
        });
        let mut poles = Vec::new();
        for law in self.ducts.iter().flat_map(|d| d.actions.iter().map(|a| &a.law)).chain(reflections) {
            poles.extend(law.poles_in(region)?);
        }
        Ok(poles)
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
