#![doc = include_str!("../README.md")]

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
    AssessOptions, Assessment, ChiSquared, Draws, Health, InferenceRecord, ParameterRecord, assess,
};
pub use density::{Calls, Energy, Gaussian, Method, Minimum, Objective, Stop, TrustRegion, minimise};
pub use error::{ForwardError, InferenceError};
pub use evidence::{
    Conflict, ConflictWarning, Entry, Evidence, LEARNT, Laplace, Offset, Predicted, RankedModel, Ranking,
    Tension, probabilities, rank,
};
pub use fit::{Fit, MapOptions, NoiseEstimate, Posterior};
pub use linearised::{Causes, Drawn, Few, LeftOut, Linearised, Moved, Told, gain, student};
pub use maxima::{Apart, Maximum, OtherMaximum, Scan, further_maxima};
pub use numbers::{chi_squared_sds, normal_cdf, normal_quantile};
pub use problem::{
    Alias, Coordinates, Correlated, Data, Forward, Kernel, Move, NoiseGroup, NoiseMode, Observation,
    Parameter, Parameters, Prediction, Prior, Structured, complex_columns, relative_noise,
};
#[cfg(feature = "nuts")]
pub use sample::Nuts;
pub use sample::{
    Importance, Integrated, LikelihoodTarget, Nested, Sampler, SamplerKind, Target, Verdict, importance,
};
