//! What is wrong with a network file.

use super::problem::ElementProblem;
use rijke_numerics::words::of_toml;

/// What is wrong with a network file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FileError {
    /// It is not TOML, or a key is unknown or has the wrong type. The message carries line, column and known
    /// keys.
    #[error("{message}")]
    Syntax {
        /// What the reader says.
        message: String,
    },
    /// An element or an end cannot be built.
    #[error("line {line}: {place}: {problem}")]
    Element {
        /// Line in the file, from 1.
        line: usize,
        /// Which element: its index from 1, its name and its type.
        place: String,
        /// What is wrong with it, and the remedy.
        #[source]
        problem: ElementProblem,
    },
    /// There is no duct.
    #[error("the file has no duct: add an [[element]] with type = \"duct\" and a length")]
    NoDuct,
    /// The search region is empty.
    #[error("line {line}: [search]: {key} must be two increasing finite numbers")]
    Search {
        /// Line of its table, from 1.
        line: usize,
        /// Which key.
        key: &'static str,
    },
    /// The mean flow is no flow.
    #[error("line {line}: [flow]: {problem}")]
    Flow {
        /// Line of its table, from 1.
        line: usize,
        /// What is wrong with it.
        #[source]
        problem: ElementProblem,
    },
    /// The network that the elements make is refused.
    #[error(transparent)]
    Network(#[from] crate::error::NetworkError),
}

impl FileError {
    pub(super) fn syntax(error: &toml::de::Error) -> Self {
        let (all, said) = (error.to_string(), error.message());
        Self::Syntax { message: all.trim_end().replace(said, &of_toml(said)) }
    }
}
