//! A flame whose heat is released along a duct, in answer to one velocity.

use super::Law;
use super::probe::{PathDuct, carry, row};
use super::{Side, SourceCoefficient};
use rijke_numerics::{C64, Jet, JetSpace};

/// One of the four coefficients of heat that is released at many places behind each other and answers to one
/// velocity before the first.
///
/// Volume flow G_k e^{-s delay_k} T u_ref at x_k is the same, upstream of the first place and downstream of
/// the last, as a step of pressure and velocity at the first: with M_k the transfer matrix of the ducts from
/// there to x_k, M_k^-1 (0, 1) = (-M_12, M_11). Between, the field is that of the equivalent step.
#[derive(Clone, Debug, PartialEq)]
pub struct SpreadFlame {
    /// T: volume flow over velocity, of all the heat.
    pub transfer: Law,
    /// What follows from place to place.
    pub sources: Vec<SpreadSource>,
    /// The ducts from the first place upstream to the velocity; none where it is that before the place.
    pub path: Vec<PathDuct>,
    /// Whether the step is that of velocity; else that of pressure.
    pub of_velocity: bool,
    /// Whether the coefficient multiplies the velocity, or the pressure.
    pub cause: SourceCoefficient,
}

/// A place of a [`SpreadFlame`].
#[derive(Clone, Debug, PartialEq)]
pub struct SpreadSource {
    /// The ducts between the place before and this one.
    pub path: Vec<PathDuct>,
    /// Part of the heat.
    pub weight: f64,
    /// Delay beside that of T, s.
    pub delay: f64,
}

impl SpreadFlame {
    pub(super) fn at(&self, s: &Jet, space: JetSpace) -> Jet {
        let mut state = [[1.0, 0.0], [0.0, 1.0]].map(|row| row.map(|v| space.real(v)));
        let mut sum = space.real(0.0);
        for source in &self.sources {
            for duct in &source.path {
                state = carry(&duct.at(s, space), &state, s);
            }
            let [on_p, on_u] = &state[0];
            let late = s.scale(C64::new(-source.delay, 0.0)).exp().scale(C64::new(source.weight, 0.0));
            sum = if self.of_velocity { &sum + &(on_p * &late) } else { &sum - &(on_u * &late) };
        }
        let stretches: Vec<_> = self.path.iter().map(|p| p.at(s, space)).collect();
        let [beta, alpha] = row(&stretches, Side::Upstream, s, space);
        let heard = match self.cause {
            SourceCoefficient::Velocity => alpha,
            SourceCoefficient::Pressure => beta,
        };
        -&(&(&sum * &self.transfer.at(s, space)) * &heard)
    }
}
