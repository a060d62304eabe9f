//! Why a study has no answer.

use rijke_candidates::CatalogueError;
use rijke_model::ModelError;

/// Why a study has no answer.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// The observations lack a point that the question is about.
    #[error(
        "the observations have no operating point {need}; measure it, or run the study on a set that has it"
    )]
    NoPoint {
        /// What is missing.
        need: String,
    },
    /// A catalogue could not be read.
    #[error(transparent)]
    Catalogue(#[from] CatalogueError),
    /// A candidate that no catalogue has.
    #[error("no catalogue has a candidate called `{0}`")]
    NoCandidate(String),
    /// No competing model could be fitted, so nothing is known for the next stage.
    #[error("none of the competing models could be fitted; of the first: {remark}")]
    NoWinner {
        /// Why the first could not.
        remark: String,
    },
    /// A hot point of which the base flow is not known.
    #[error(
        "the base flow of operating point {point} is not known; run `rijke flow` on the same observations"
    )]
    NoBaseState {
        /// The point.
        point: String,
    },
    /// The pipe flow has no answer.
    #[error(transparent)]
    Flow(#[from] rijke_flow::FlowError),
    /// The virtual laboratory cannot be set up.
    #[error(transparent)]
    Laboratory(#[from] rijke_lab::LabError),
    /// A model could not be built or trained.
    #[error(transparent)]
    Model(#[from] ModelError),
}
