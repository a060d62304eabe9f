//! The evidence by draws, without Laplace's approximation: importance sampling, and the samplers (nested
//! sampling; NUTS with bridge sampling).
//!
//! Knows a fit to start from, and neither its Laplace evidence nor other maxima.

#[cfg(feature = "nuts")]
mod bridge;
mod choice;
mod importance;
mod likelihood;
mod nested;
#[cfg(feature = "nuts")]
mod nuts;
mod sampler;

pub use choice::SamplerKind;
pub use importance::{Importance, importance};
pub use likelihood::LikelihoodTarget;
pub use nested::Nested;
#[cfg(feature = "nuts")]
pub use nuts::Nuts;
pub use sampler::{Integrated, Sampler, Target, Verdict};

pub(crate) use importance::weighed;
