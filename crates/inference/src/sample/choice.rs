//! The samplers by name, for those who choose one at run time.

use super::nested::Nested;
use super::sampler::Sampler;
use crate::error::InferenceError;
use rijke_numerics::Streams;

/// A sampler by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SamplerKind {
    /// Nested sampling.
    Nested,
    /// NUTS with bridge sampling; needs the feature `nuts`.
    Nuts,
}

impl SamplerKind {
    /// The sampler for a statistical error of about `error` nats, for a fit whose Occam factor is `ln_occam`.
    ///
    /// # Errors
    /// [`InferenceError::Sampler`] if it is not part of this build.
    pub fn build(
        self,
        error: f64,
        ln_occam: f64,
        parameters: usize,
        streams: Streams,
    ) -> Result<Box<dyn Sampler>, InferenceError> {
        match self {
            Self::Nested => Ok(Box::new(Nested::with_error(error, -ln_occam, parameters, streams))),
            #[cfg(feature = "nuts")]
            Self::Nuts => Ok(Box::new(super::nuts::Nuts::with_error(error, streams))),
            #[cfg(not(feature = "nuts"))]
            Self::Nuts => Err(InferenceError::Sampler {
                sampler: "the gradient sampler",
                problem: "this program was built without it; build with `--features nuts`".to_owned(),
            }),
        }
    }
}
