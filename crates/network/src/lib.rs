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

mod along;
mod block;
mod budget;
mod chain;
mod chains;
mod coefficients;
mod contour;
mod error;
pub mod file;
pub mod flow_chain;
mod forced;
mod hearing;
pub mod laws;
pub mod levine_schwinger;
mod mode;
mod newton;
mod response;
mod search;
mod sensitivity;
mod sweep;
mod tangents;
mod tracking;
mod transfer;
pub mod wall;

pub use along::{Device, Station};
pub use budget::{Budget, Exchange};
pub use chain::{Network, Segment, Slot};
pub use chains::{Balance, Chain, Power};
pub use coefficients::{At, Coefficients, Constant, Laws, Pole};
pub use contour::{Mode, Modes, Region};
pub use error::NetworkError;
pub use forced::{Forced, Source, Transfer};
pub use newton::{Newton, Root, Workspace};
pub use response::{Places, Response};
pub use search::zeros_of;
pub use sensitivity::{Derivatives, Sensitivities};
pub use tracking::follow;

/// The example of the README, compiled and run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
