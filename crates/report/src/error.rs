//! What can go wrong between numbers and pages.

use std::path::PathBuf;

/// Why no report was made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// A file of numbers cannot be read.
    #[error("{}: cannot be read", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file does not hold the numbers that its name promises.
    #[error("{}: line {}, column {}: {source}", path.display(), source.line(), source.column())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Where and why.
        source: serde_json::Error,
    },
    /// A list of a file is of another length than its figure needs.
    #[error("{}: {place}: has {have} entries, needs {need}; the file is damaged: run the study again", path.display())]
    Shape {
        /// The file.
        path: PathBuf,
        /// The list.
        place: String,
        /// Entries found.
        have: usize,
        /// Entries needed.
        need: usize,
    },
    /// There is nothing to report.
    #[error("no numbers of any study")]
    Nothing,
    /// A file cannot be written.
    #[error("{}: cannot be written", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A table cannot be written as CSV.
    #[error("cannot write a table as CSV")]
    Table(#[from] csv::Error),
    /// The template of the page is wrong.
    #[error("the template of the page is wrong")]
    Template(#[from] minijinja::Error),
}
