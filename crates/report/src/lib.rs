//! Numbers to SVG, CSV and HTML. Draws what the records of [`rijke_studies`] hold and computes nothing of its own, so the
//! same numbers give the same bytes.
//!
//! # Conventions
//!
//! * A study's numbers are one JSON file of its record, `empty_tube.json`, `prongs.json` and so on; the fields of
//!   [`Numbers`] say which.
//! * Every panel of every figure says whether its data were measured or virtual.
//! * Labels are written once, as `*italic*`, `_{below}` and `^{above}`, and become SVG, HTML or plain text.
//! * Coordinates are rounded to a hundredth of a pixel.
//!
//! # Example
//!
//! ```no_run
//! let numbers = rijke_report::Numbers::read("results/numbers".as_ref())?;
//! rijke_report::Report::new(&numbers)?.write("results".as_ref())?;
//! # Ok::<(), rijke_report::ReportError>(())
//! ```

mod base_flow;
mod comparison;
mod draw;
mod error;
mod figures;
mod gallery;
mod modes;
mod numbers;
mod page;
mod prior;
mod record;
mod response;
mod response_study;
mod shape;
mod sheet;
mod stability;
mod study;
mod table;

pub use base_flow::{BaseFlow, FlowAt, FlowAtPower, FlowRun, FlowUnknown};
pub use error::ReportError;
pub use gallery::gallery;
pub use modes::{ModeCurves, ModesFigure};
pub use numbers::Numbers;
pub use prior::{PriorFigure, PriorModel, PriorSeries};
pub use record::{Look, RecordCurve, RecordFigure, RecordPanel};
pub use response::{ResponseCurve, ResponseFigure};
pub use response_study::response_page;
pub use stability::StabilityMap;
pub use study::{StudyHead, StudyPage};

use std::{fs, path::Path};

/// The files of a report, in memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Report {
    files: Vec<(String, Vec<u8>)>,
}

impl Report {
    /// Draws everything that the numbers allow: `index.html`, `figures/*.svg` and `tables/*.csv`.
    ///
    /// # Errors
    /// [`ReportError::Nothing`] if there are no numbers at all.
    pub fn new(numbers: &Numbers) -> Result<Self, ReportError> {
        let items = numbers.items();
        if items.is_empty() {
            return Err(ReportError::Nothing);
        }
        let mut files = Vec::new();
        for item in &items {
            for figure in &item.figures {
                files.push((format!("figures/{}.svg", figure.id), figure.svg().into_bytes()));
            }
            for sheet in &item.sheets {
                files.push((format!("tables/{}.csv", sheet.id), sheet.csv()?));
            }
        }
        // Last, so that what it names is there when it is.
        files.push(("index.html".to_owned(), page::render(&items)?.into_bytes()));
        Ok(Self { files })
    }

    /// The files: path within the folder of the report, and content; the page comes last.
    #[must_use]
    pub fn files(&self) -> &[(String, Vec<u8>)] {
        &self.files
    }

    /// Writes the files into a folder, which is made if necessary. Each file appears whole or not at all.
    ///
    /// # Errors
    /// [`ReportError::Write`] names the file that could not be written.
    pub fn write(&self, folder: &Path) -> Result<(), ReportError> {
        for (name, content) in &self.files {
            let path = folder.join(name);
            let partial = path.with_extension("partial");
            let written = path
                .parent()
                .map_or(Ok(()), fs::create_dir_all)
                .and_then(|()| fs::write(&partial, content))
                .and_then(|()| fs::rename(&partial, &path));
            written.map_err(|source| ReportError::Write { path, source })?;
        }
        Ok(())
    }
}
