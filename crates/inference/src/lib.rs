//! Bayesian inference for models with a handful of parameters: the most probable parameters, their
//! uncertainty, and the evidence for the model, by Laplace's method; knows nothing of tubes or of acoustics.
//!
//! * [`Parameters`], [`Prior`]: what is unknown, in which unit, and what was known before.
//! * [`Forward`]: the model, physical parameters -> predicted data with first and second derivatives.
//! * [`Data`]: what was measured, with covariances and groups of noise that may float.
//! * [`Posterior`]: the two together; [`Posterior::map`], [`Posterior::laplace`], [`Evidence`], [`rank`].
//! * [`Objective`]: the same methods for any negative log density.
//!
//! # Conventions
//!
//! * The cost is J = 1/2 r' C^-1 r + 1/2 ln det(2 pi C) + the same two terms for the prior, in nats: minus the
//!   logarithm of P(D|a) P(a). Equation (4) of Juniper & Yoko (2022) drops the halves and the determinants that
//!   its equations (5), (6) and (9) and its floating variances need.
//! * A forward model sees *physical* parameters. Minimisation, Laplace's Gaussian and the Occam factor live in
//!   *working* coordinates, one real number per parameter ([`Coordinates`]); the Jacobian of the map is part of
//!   the prior density. Laplace's evidence depends on that choice; an affine change alone does not matter.
//! * Floated noise is maximised and carries no Occam factor; inferred noise is a parameter, ln sigma, and does.
//! * Standard deviations are called `sd`; whatever is called variance or covariance is one.
//!
//! # Example
//!
//! A straight line through three points with known noise.
//!
//! ```
//! use rijke_inference::*;
//! use rijke_numerics::{Matrix, Order};
//!
//! struct Line;
//! impl Forward for Line {
//!     fn predict(&self, a: &[f64], _: Order) -> Result<Prediction, ForwardError> {
//!         let x = [0.0, 1.0, 2.0];
//!         Ok(Prediction {
//!             values: x.iter().map(|x| a[0] + a[1] * x).collect(),
//!             jacobian: Matrix::from_fn(3, 2, |k, i| if i == 0 { 1.0 } else { x[k] }),
//!             curvature: vec![0.0; 9], // three rows of a packed 2 x 2 triangle
//!         })
//!     }
//! }
//!
//! let prior = Prior::Normal { mean: 0.0, sd: 10.0 };
//! let parameters = Parameters::new(vec![
//!     Parameter::new("offset", "a", "V", prior),
//!     Parameter::new("slope", "b", "V/m", prior),
//! ])?;
//! let observation = Observation::new("run 1", vec![1.1, 2.9, 5.2]).with_independent_noise(0, &[0, 1, 2]);
//! let data = Data::new(vec![observation], vec![NoiseGroup::fixed("voltage", "V", 0.1)])?;
//! let posterior = Posterior::new(&Line, &data, &parameters)?;
//! let fit = posterior.map(&MapOptions::default())?;
//! let laplace = posterior.laplace(&fit)?;
//! assert!((fit.parameters[1] - 2.05).abs() < 1e-3);
//! assert!((laplace.evidence.ln_marginal - (laplace.evidence.ln_best_fit + laplace.evidence.ln_occam)).abs() < 1e-12);
//! # Ok::<(), InferenceError>(())
//! ```

mod alias;
mod block;
#[cfg(feature = "nuts")]
mod bridge;
mod chain;
mod checks;
mod conflict;
mod data;
pub mod ensemble;
mod error;
mod explore;
mod forward;
mod health;
mod held;
mod importance;
mod kernelled;
mod laplace;
mod linearised;
mod map;
mod marginal;
mod memory;
mod minimise;
mod misfit;
mod modes;
mod nested;
mod normal;
#[cfg(feature = "nuts")]
mod nuts;
mod objective;
mod parameters;
mod posterior;
mod predictive;
mod prior;
mod quadratic;
mod rank;
mod record;
mod referee;
mod scale;
mod settle;
mod simulate;
mod starts;
mod stop;
mod structured;
mod surveyed;
mod tail;
mod woodbury;

pub use alias::{Alias, Move, Repeat};
pub use chain::{Chain, ChainStage};
pub use conflict::{Conflict, ConflictWarning, LEARNT, Offset, Tension};
pub use data::{Data, NoiseGroup, NoiseMode, Observation, relative_noise};
pub use error::InferenceError;
pub use forward::{Forward, ForwardError, Prediction};
pub use health::{AssessOptions, Assessment, Health, assess};
pub use importance::{Importance, importance};
pub use laplace::{Evidence, Gaussian, Laplace};
pub use linearised::{Drawn, LeftOut, Linearised, Told, gain};
pub use map::{Fit, MapOptions, NoiseEstimate};
pub use marginal::MarginalFit;
pub use minimise::{Method, Minimum, TrustRegion, minimise};
pub use misfit::Kernel;
pub use modes::{Apart, Maximum, Mode};
pub use nested::Nested;
pub use normal::{normal_cdf, normal_quantile};
#[cfg(feature = "nuts")]
pub use nuts::Nuts;
pub use objective::{Energy, Objective};
pub use parameters::Parameters;
pub use posterior::Posterior;
pub use predictive::Predicted;
pub use prior::{Coordinates, Parameter, Prior};
pub use rank::{Entry, RankedModel, Ranking, rank};
pub use record::{Draws, ParameterRecord, Record, evidence_csv};
pub use referee::{Judged, LikelihoodTarget, Referee, RefereeKind, Target, Verdict};
pub use simulate::{Calibration, ModelCheck, ParameterCheck};
pub use stop::{Calls, Stop};
pub use structured::{Correlated, Structured, complex_columns};
pub use surveyed::{Surveyed, survey};
pub use tail::chi_squared_sds;
