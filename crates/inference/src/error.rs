//! What can go wrong, with numbers.

use rijke_numerics::DenseError;

/// Why an inference has no answer.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum InferenceError {
    /// A prior whose numbers contradict each other or are not numbers.
    #[error("the prior of parameter '{parameter}' is impossible: {problem}")]
    BadPrior {
        /// Name of the parameter.
        parameter: String,
        /// What is wrong with it.
        problem: String,
    },
    /// A width of a prior that double precision cannot work with: its square or inverse overflows, or it is
    /// lost beside the mean.
    #[error(
        "the prior of parameter '{parameter}' has {what} = {value:e}, but it must lie between {low:e} and {high:e}; choose a unit or a width in which it does"
    )]
    PriorScale {
        /// Name of the parameter.
        parameter: String,
        /// Which number of the prior.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The smallest that is accepted.
        low: f64,
        /// The largest that is accepted.
        high: f64,
    },
    /// An alias whose step is zero or not a number.
    #[error(
        "the model cannot repeat itself at {value} of parameter '{parameter}': give a finite step that is not zero"
    )]
    BadAlias {
        /// Name of the parameter.
        parameter: String,
        /// The step, or the place of the mirror.
        value: f64,
    },
    /// Two parameters share a name, or a name is unknown.
    #[error("parameter '{parameter}' {problem}; known: {known}")]
    BadName {
        /// The name.
        parameter: String,
        /// "is unknown" or "is given twice".
        problem: &'static str,
        /// All names.
        known: String,
    },
    /// A joint prior covariance that is not symmetric positive definite in size or content.
    #[error("the joint prior of {names} is not usable: {problem}")]
    BadJoint {
        /// The parameters of the block.
        names: String,
        /// What is wrong with it.
        problem: String,
    },
    /// An observation holds a number that is not finite, or matrices of the wrong size.
    #[error("observation '{observation}': {problem}")]
    BadObservation {
        /// Its label.
        observation: String,
        /// What is wrong with it.
        problem: String,
    },
    /// A noise group with an impossible standard deviation.
    #[error("noise group '{group}': {problem}")]
    BadNoise {
        /// Its name.
        group: String,
        /// What is wrong with it.
        problem: String,
    },
    /// The model predicted a different number of values from the number of data.
    #[error("the model returned {what} of size {found}, but {expected} is needed")]
    Shape {
        /// Which array.
        what: &'static str,
        /// Its size.
        found: usize,
        /// The size needed.
        expected: usize,
    },
    /// A setting that no search can follow.
    #[error("{name} is {value}: give {need}")]
    Setting {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        need: &'static str,
    },
    /// The number of given values is not the number of parameters.
    #[error("{found} starting values were given for {expected} numbers: give one for each")]
    StartSize {
        /// Number given.
        found: usize,
        /// Number needed.
        expected: usize,
    },
    /// A point outside the bounds of a prior; a minimiser shortens its step.
    #[error("parameter '{parameter}' = {value} lies outside its bounds {low} .. {high}")]
    OutsideBounds {
        /// Name of the parameter.
        parameter: String,
        /// Its value.
        value: f64,
        /// Lower bound.
        low: f64,
        /// Upper bound.
        high: f64,
    },
    /// The covariance of an observation is singular at the present noise; a minimiser shortens its step.
    #[error(
        "the covariance of observation '{observation}' is not positive definite ({source}); give it a floor or a noise group on every element"
    )]
    SingularCovariance {
        /// Its label.
        observation: String,
        /// The failed factorisation.
        source: DenseError,
    },
    /// The cost is not a finite number; a minimiser shortens its step.
    #[error("the cost is {value} at {at}")]
    NotFinite {
        /// The value.
        value: f64,
        /// The point, in words.
        at: String,
    },
    /// The forward model failed.
    #[error("the forward model failed: {0}")]
    Forward(#[from] ForwardError),
    /// The model fails at the starting point, so there is nothing to improve on.
    #[error("the model cannot be evaluated at the starting point {at}: {source}")]
    NoStart {
        /// The starting point, in words.
        at: String,
        /// Why.
        source: Box<InferenceError>,
    },
    /// The second derivative A of the cost is not positive definite: the point is no isolated maximum of the
    /// posterior.
    #[error(
        "the Hessian of the cost is not positive definite (lowest eigenvalue {lowest:.3e} in units of the prior, along {direction})"
    )]
    NoLaplace {
        /// Lowest eigenvalue of A scaled by the scale of each parameter.
        lowest: f64,
        /// The combination of parameters, in words.
        direction: String,
    },
    /// An evidence was asked for although a prior is improper.
    #[error("parameter '{parameter}' has a flat improper prior, so the evidence is not defined")]
    Improper {
        /// Name of the parameter.
        parameter: String,
    },
    /// A block of data too large for what needs its covariance as a dense matrix: residuals with
    /// leave-one-out scores.
    #[error(
        "observation '{observation}' has {size} data; at most {limit} can be treated with a dense covariance"
    )]
    TooLarge {
        /// Its label.
        observation: String,
        /// Number of its data.
        size: usize,
        /// The most.
        limit: usize,
    },
    /// A sampler that could not go on, or is not part of this build.
    #[error("{sampler} stopped: {problem}")]
    Sampler {
        /// Which.
        sampler: &'static str,
        /// Why.
        problem: String,
    },
    /// Dense algebra failed.
    #[error(transparent)]
    Dense(#[from] DenseError),
}

impl InferenceError {
    /// True if the failure is one of the point, not of the problem: a minimiser shortens its step and goes
    /// on.
    #[must_use]
    pub fn is_recoverable(&self) -> bool {
        match self {
            Self::Forward(error) => error.is_recoverable(),
            Self::OutsideBounds { .. } | Self::SingularCovariance { .. } | Self::NotFinite { .. } => true,
            _ => false,
        }
    }
}

/// A forward model that could not be evaluated.
#[derive(Debug, thiserror::Error)]
#[error("{source}")]
pub struct ForwardError {
    recoverable: bool,
    source: Box<dyn std::error::Error + Send + Sync>,
}

impl ForwardError {
    /// The model has no answer at this point, but may have one nearby: an eigenvalue that was lost, say.
    pub fn recoverable(source: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> Self {
        Self { recoverable: true, source: source.into() }
    }

    /// No point will do better: a missing file, a wrong size.
    pub fn fatal(source: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> Self {
        Self { recoverable: false, source: source.into() }
    }

    /// True for [`ForwardError::recoverable`].
    #[must_use]
    pub fn is_recoverable(&self) -> bool {
        self.recoverable
    }
}
