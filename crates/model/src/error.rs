//! Why a model cannot be built or evaluated.

use rijke_flow::FlowError;
use rijke_inference::{InferenceError, Stop};
use rijke_network::NetworkError;

/// Why a model cannot be built, evaluated or trained.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// Two candidates have a parameter of the same name, so that a value could not be given by name.
    #[error("both `{first}` and `{second}` have a parameter called `{parameter}`; rename one of them")]
    SameName {
        /// The parameter.
        parameter: String,
        /// The first candidate.
        first: String,
        /// The second candidate.
        second: String,
    },
    /// Two candidates of one role: they compete, and cannot act together.
    #[error("`{first}` and `{second}` both model the {role}; choose one")]
    SameRole {
        /// The role.
        role: String,
        /// The first candidate.
        first: String,
        /// The second candidate.
        second: String,
    },
    /// A value for a parameter that no candidate has.
    #[error("no chosen candidate has a parameter called `{name}`; known: {known}")]
    UnknownParameter {
        /// The name.
        name: String,
        /// The names that exist.
        known: String,
    },
    /// The wrong number of parameter values.
    #[error("{found} parameter values were given for {expected} free parameters")]
    Count {
        /// How many there are.
        expected: usize,
        /// How many were given.
        found: usize,
    },
    /// An operating point without a usable ping.
    #[error("operating point {point} has no accepted ping; leave it out or process its records again")]
    NoPing {
        /// The point.
        point: String,
    },
    /// A microphone that does not exist, or a selection without the reference.
    #[error("microphone {microphone} is not among the {count} of the rig, or the reference is not selected")]
    Microphone {
        /// Its index.
        microphone: usize,
        /// Number of microphones.
        count: usize,
    },
    /// The network has no answer; often recoverable by a smaller step.
    #[error("at operating point {point}: {source}")]
    Network {
        /// The point.
        point: String,
        /// Why.
        source: NetworkError,
    },
    /// The base state is unsound.
    #[error("the base state of operating point {point}: {source}")]
    Flow {
        /// The point.
        point: String,
        /// Why.
        source: FlowError,
    },
    /// A file of a saved model that cannot be read or written.
    #[error("{}: {problem}", file.display())]
    File {
        /// The file.
        file: std::path::PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// A law of a saved model that is no formula.
    #[error("candidate `{candidate}`: {source}")]
    Formula {
        /// The candidate.
        candidate: String,
        /// What is wrong.
        source: Box<rijke_candidates::FormulaError>,
    },
    /// The inference failed.
    #[error(transparent)]
    Inference(#[from] InferenceError),
    /// The search for the best parameters ended without converging.
    #[error("the fit of `{model}` ended without converging: {stop}")]
    NotConverged {
        /// Which model.
        model: String,
        /// How the search ended.
        stop: Stop,
    },
}

impl ModelError {
    /// Whether other parameter values nearby may do better.
    #[must_use]
    pub fn is_recoverable(&self) -> bool {
        matches!(self, Self::Network { source, .. } if source.is_recoverable())
    }
}
