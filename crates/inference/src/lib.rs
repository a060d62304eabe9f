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
//! # Folders
//!
//! Each knows only those before it: `numbers`, `problem` and `density`, `covariance`, `fit`, `evidence` and `sample`, `maxima`,
//! `assessment`. [`ensemble`] needs `numbers` alone.
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

mod assessment;
mod covariance;
mod density;
pub mod ensemble;
mod error;
mod evidence;
mod fit;
mod linearised;
mod maxima;
mod numbers;
mod problem;
mod sample;

pub use assessment::{
    AssessOptions, Assessment, Calibration, Chain, ChainStage, Draws, Health, ModelCheck, ParameterCheck,
    ParameterRecord, Record, Surveyed, assess, evidence_csv, survey,
};
pub use density::{Calls, Energy, Gaussian, Method, Minimum, Objective, Stop, TrustRegion, minimise};
pub use error::{ForwardError, InferenceError};
pub use evidence::{
    Conflict, ConflictWarning, Entry, Evidence, LEARNT, Laplace, MarginalFit, Offset, Predicted, RankedModel,
    Ranking, Tension, rank,
};
pub use fit::{Fit, MapOptions, NoiseEstimate, Posterior};
pub use linearised::{Drawn, LeftOut, Linearised, Told, gain};
pub use maxima::{Apart, Maximum, Mode};
pub use numbers::{chi_squared_sds, normal_cdf, normal_quantile};
pub use problem::{
    Alias, Coordinates, Correlated, Data, Forward, Kernel, Move, NoiseGroup, NoiseMode, Observation,
    Parameter, Parameters, Prediction, Prior, Repeat, Structured, complex_columns, relative_noise,
};
#[cfg(feature = "nuts")]
pub use sample::Nuts;
pub use sample::{
    Importance, Judged, LikelihoodTarget, Nested, Referee, RefereeKind, Target, Verdict, importance,
};
