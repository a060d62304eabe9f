//! What can go wrong between numbers and pages.

use std::path::PathBuf;

/// Why no page was made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReportError {
    /// There is nothing to report.
    #[error("no numbers of any stage")]
    Nothing,
    /// A file cannot be written.
    #[error("{}: cannot be written", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A drawing cannot become a PDF.
    #[error("not a drawing of rijke-report: {0}")]
    Drawing(String),
    /// A table cannot be written as CSV.
    #[error("cannot write a table as CSV")]
    Table(#[from] rijke_numerics::Failure),
}
