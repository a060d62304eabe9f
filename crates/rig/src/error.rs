//! What can be wrong with a file, said with the file, the place in it and the remedy.

use crate::problem::Problem;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// A file that cannot be read, understood, believed or written. None of these can be survived: the input has
/// to be corrected. (A record that is merely poor is a [`crate::Rejection`], not an error.)
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RigError {
    /// The file is absent, may not be read, is no file, or is too large.
    #[error("{}: cannot be read ({cause}){}", path.display(), remedy(cause))]
    Read {
        /// Which file.
        path: PathBuf,
        /// The operating system's reason.
        cause: std::io::Error,
    },
    /// A file could not be written.
    #[error("{}: cannot be written ({cause}); check free space and permissions", path.display())]
    Write {
        /// Which file.
        path: PathBuf,
        /// The operating system's reason.
        cause: std::io::Error,
    },
    /// The TOML or CSV does not parse, a key is unknown or missing, or a value has the wrong type.
    #[error("{}:{line}:{column}: {message}", path.display())]
    Syntax {
        /// Which file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What the parser says, with the list of known keys where a key is unknown.
        message: String,
    },
    /// The file parses and its values make no sense.
    #[error("{}: {place}: {problem}", path.display())]
    Invalid {
        /// Which file.
        path: PathBuf,
        /// Key, channel or row.
        place: String,
        /// What is wrong and what to do about it.
        problem: Problem,
    },
    /// Data of other people that are not here.
    #[error(
        "{}: the data are not part of this folder: set the variable {} to a folder that holds `{}`; get them from {}",
        path.display(), data.variable, data.folder, data.obtain
    )]
    Elsewhere {
        /// The file that says so.
        path: PathBuf,
        /// Where they would be.
        data: Elsewhere,
    },
    /// A folder without the file that makes it a record set.
    #[error(
        "{}: no such file, so {} is not a record set (or its writing was interrupted); a record set is written by \
         `rijke lab` or by hand as described in docs/records-format.md",
        path.display(),
        path.parent().unwrap_or(Path::new(".")).display()
    )]
    NotARecordSet {
        /// The manifest that is missing.
        path: PathBuf,
    },
}

/// Where data are that are not part of a folder.
#[derive(Clone, Debug, PartialEq, Eq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Elsewhere {
    /// The environment variable that names the folder of all such data.
    pub variable: String,
    /// The folder within.
    pub folder: String,
    /// How to get them.
    pub obtain: String,
}

impl Elsewhere {
    /// The folder, if it is here.
    #[must_use]
    pub fn find(&self) -> Option<PathBuf> {
        let set = std::env::var_os(&self.variable).filter(|value| !value.is_empty());
        set.map(|value| PathBuf::from(value).join(&self.folder)).filter(|path| path.is_dir())
    }
}

/// What can be done about a file that cannot be read.
fn remedy(cause: &std::io::Error) -> &'static str {
    match cause.kind() {
        ErrorKind::InvalidInput | ErrorKind::FileTooLarge | ErrorKind::InvalidData => "",
        _ => "; check the name and the permissions",
    }
}

impl RigError {
    /// The value at `place` in `path` is wrong.
    #[must_use]
    pub fn invalid(path: &Path, place: impl Into<String>, problem: Problem) -> Self {
        Self::Invalid { path: path.to_owned(), place: place.into(), problem }
    }

    /// Turns an I/O failure on `path` into a read error.
    pub(crate) fn read(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |cause| Self::Read { path, cause }
    }

    /// Turns an I/O failure on `path` into a write error.
    pub(crate) fn write(path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |cause| Self::Write { path, cause }
    }
}
