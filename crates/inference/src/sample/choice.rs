//! The referees by name, for those who choose one at run time.

use super::nested::Nested;
use super::referee::Referee;
use crate::error::InferenceError;
use rijke_numerics::Streams;

/// A referee by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RefereeKind {
    /// Nested sampling.
    Nested,
    /// NUTS with bridge sampling; needs the feature `nuts`.
    Nuts,
}

impl RefereeKind {
    /// The referee for a statistical error of about `error` nats, for a fit whose Occam factor is `ln_occam`.
    ///
    /// # Errors
    /// [`InferenceError::Referee`] if it is not part of this build.
    pub fn build(
        self,
        error: f64,
        ln_occam: f64,
        parameters: usize,
        streams: Streams,
    ) -> Result<Box<dyn Referee>, InferenceError> {
        match self {
            Self::Nested => Ok(Box::new(Nested::with_error(error, -ln_occam, parameters, streams))),
            #[cfg(feature = "nuts")]
            Self::Nuts => Ok(Box::new(super::nuts::Nuts::with_error(error, streams))),
            #[cfg(not(feature = "nuts"))]
            Self::Nuts => Err(InferenceError::Referee {
                referee: "the gradient sampler",
                problem: "this program was built without it; build with `--features nuts`".to_owned(),
            }),
        }
    }
}
