//! The reader of truth files.

use rijke_numerics::words::{line_of, of_toml};
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a truth file says nothing.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TruthFault {
    /// It cannot be read.
    #[error("{}: cannot be read ({cause}); check the name", path.display())]
    Read {
        /// Which file.
        path: PathBuf,
        /// The operating system's reason.
        cause: std::io::Error,
    },
    /// It does not parse.
    #[error("{}:{line}: {message}", path.display())]
    Parse {
        /// Which file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What the parser says.
        message: String,
    },
}

/// Reads a truth file.
pub(crate) fn read<T: DeserializeOwned>(path: &Path) -> Result<T, TruthFault> {
    let text =
        rijke_numerics::read_text(path).map_err(|cause| TruthFault::Read { path: path.to_owned(), cause })?;
    parse(&text, path)
}

/// Reads the text of the truth file `path`.
pub(crate) fn parse<T: DeserializeOwned>(text: &str, path: &Path) -> Result<T, TruthFault> {
    toml::from_str(text).map_err(|error| TruthFault::Parse {
        path: path.to_owned(),
        line: line_of(text, error.span().map_or(0, |span| span.start)),
        message: of_toml(error.message()),
    })
}
