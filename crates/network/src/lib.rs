//! Acoustic networks: eigenvalues, modes, and their first and second derivatives.
//!
//! A network is a chain of duct segments with local feedback between them and a reflection at either end. It knows
//! nothing of parameters, candidates or data: a caller hands over coefficients as functions of s and of any real
//! parameters ([`Coefficients`]) and gets back s and the mode shape with their derivatives ([`Response`]).
//!
//! # Conventions
//!
//! * Time dependence e^{st}, s = sigma + i omega: growth rate sigma in 1/s (negative decays), angular frequency in
//!   rad/s. SI units.
//! * p = f + g, u = (f - g)/(rho c); f travels downstream (+x). R_u = f/g at x = 0 and R_d = g/f at x = L, both with
//!   the minus sign of an open end.
//! * Jumps (1), (2): p2 - p1 = -k_mu u1 - k_mp p1, u2 - u1 = -k_eu u1 - k_ep p1. A heat source in phase with velocity
//!   has k_eu < 0. A sudden area change keeps p and A u and so is k_eu = 1 - A1/A2.
//! * Wall losses live in the propagation, dp/dx = -(s rho + k_mu/dx) u, du/dx = -(s/(rho c^2) + k_ep/dx) p; the
//!   paper's lumped scheme is feedback at the places between segments.
//! * Everything is analytic in s; a law that is not makes Newton, derivatives and contour counts wrong.
//! * Mode shapes are relative to the pressure at a reference place.
//!
//! See [`Network`] for a first example, [`file::read`] for a network as a file, [`Coefficients`] for laws with parameters,
//! [`flow_chain`] for mean flow.

mod chain;
mod chains;
mod error;
pub mod file;
pub mod flow_chain;
pub mod laws;
mod modes;
mod plane;
mod respond;
mod sense;
mod slot;

pub use chain::coefficients::{At, Coefficients, Constant, Laws, Pole};
pub use chain::network::{Network, Segment};
pub use chain::workspace::Workspace;
pub use chains::{Balance, Chain, Power};
pub use error::NetworkError;
pub use laws::{levine_schwinger, wall};
pub use plane::modes::{Mode, Modes};
pub use plane::newton::{Newton, Root};
pub use plane::region::Region;
pub use plane::tracking::follow;
pub use plane::zeros::zeros_of;
pub use respond::answer::{Places, Response};
pub use respond::forced::{Forced, Source, Transfer};
pub use sense::along::{Device, Station};
pub use sense::budget::{Budget, Exchange};
pub use sense::sensitivity::{Derivatives, Sensitivities};
pub use slot::Slot;

/// The example of the README, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
