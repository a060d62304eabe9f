//! Competing models of each component of a rig, as effects on the feedback and reflection coefficients of an
//! acoustic network. Does not know which candidate wins, nor any data.
//!
//! A [`Candidate`] is a few parameters with priors and a list of [`Effect`]s: *where* it acts ([`Place`]), on
//! *which* coefficient ([`Coefficient`]), and by *what law* ([`Law`]). Laws are formulas in a TOML file, or Rust
//! for what a formula cannot say. Both are evaluated on [`rijke_numerics::Jet`], so that exact first and second
//! derivatives with respect to the parameters and s come with every value.
//!
//! # Conventions
//!
//! * s = sigma + i omega, time dependence e^{st}; SI units.
//! * Coefficients enter the jump conditions (1), (2) of Juniper & Yoko 2022: p2 - p1 = -k_mu u1 - k_mp p1,
//!   u2 - u1 = -k_eu u1 - k_ep p1. A heater that adds heat in phase with velocity has k_eu < 0. Along a length
//!   ([`Place::Tube`], [`Place::Prongs`]) a law gives the coefficient *per metre*.
//! * Effects of several candidates on one coefficient add up, so the sum is the model and the list its budget.
//! * Every law is analytic in s. Where the paper writes omega = Im(s), the law is continued: e^{-s tau} for a
//!   phase lag omega tau, sqrt(s rho mu) for sqrt(i omega rho mu). The two differ by about |sigma|/omega, 1 % here.
//!   `re`, `im`, `abs`, `arg` and `conj` of anything that depends on s are refused when the file is read.
//! * Parameters are real. A complex coefficient is written `alpha_r + i*alpha_i`.
//!
//! # Example
//!
//! ```
//! let file = r#"
//! [[candidate]]
//! id = "prongs.drag"
//! role = "prongs"
//! name = "real drag"
//! cite = ["Juniper & Yoko 2022, Table 2, model 1"]
//! parameters.alpha = { symbol = "α", unit = "1", prior = { normal = { mean = 1.0, sd = 1.0 } } }
//! [[candidate.effect]]
//! acts_at = "prongs"
//! mu = "alpha * P_p/P_t * wall_mu"
//! ep = "alpha * P_p/P_t * wall_ep"
//! "#;
//! let catalogue = rijke_candidates::Catalogue::from_toml(file, "example.toml")?;
//! assert_eq!(catalogue.candidates()[0].effects.len(), 2);
//! # Ok::<(), rijke_candidates::CatalogueError>(())
//! ```

mod candidate;
mod catalogue;
mod formula;
mod here;
mod symbols;
#[cfg(test)]
mod testing;

pub use candidate::{Candidate, Coefficient, Effect, Law, Place};
pub use catalogue::{Catalogue, CatalogueError, CatalogueProblem};
pub use formula::{Formula, FormulaError, Problem, Scope, unit_fault};
pub use here::{Dual, Here, Surroundings};
pub use symbols::{Meaning, SYMBOLS, Symbol};
