//! A bench: any chain of ducts with heat sources, obstacles and side branches, told by a truth file, solved
//! by the laboratory's own integrator and observed with noise. It makes the data of the folders under
//! `examples/`. Knows nothing of the tube of the paper.
//!
//! In a duct the distributed equations are integrated in x, to first order in the Mach number of the mean
//! flow, with U the volume velocity and A the cross-section:
//!
//! ```text
//! dp/dx = -(s rho/(1 - F_v) + rho du/dx)/A U + s u/c^2 p
//! dU/dx = -A (s/(rho c^2) (1 + (gamma - 1) F_t) + du/dx/p_0) p + s u/c^2 U + A (gamma - 1)/(gamma p_0) q'
//! ```
//!
//! They are the linearised balances of momentum and energy (Dowling & Stow, J. Propul. Power 19, 2003, 751)
//! at uniform p_0; F_v and F_t are the boundary layers of Zwikker and Kosten ([`crate::walls`]), u the mean
//! velocity. Terms in u^2/c^2 and what spots of entropy do to sound are left out. A change of area keeps U;
//! the pressure loses the inertia of Ingard's end correction and, to first order in u, what a contraction
//! (total pressure kept) or an expansion (Borda and Carnot) takes.
//!
//! [`run`] makes one set of observations; [`Bench`] keeps a truth for many seeds.

mod base;
mod campaign;
mod chain;
mod ends;
mod error;
mod modes;
mod observe;
mod parts;
mod response;
mod truth;
mod value;

pub use error::BenchError;
pub use observe::{Bench, BenchObservations, BenchReading, Measured, run};
