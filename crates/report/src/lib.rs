//! Numbers to SVG, CSV and HTML. Draws what the records of [`rijke_engine`] hold and computes nothing of its own, so the same numbers
//! give the same bytes.
//!
//! # Conventions
//!
//! * Every panel of every figure says whether its data were measured or virtual.
//! * Labels are written once, as `*italic*`, `_{below}` and `^{above}`, and become SVG, HTML or plain text.
//! * Coordinates are rounded to a tenth of a pixel.

mod draw;
mod error;
mod gallery;
mod modes;
mod record;
mod response;
mod response_study;
mod stability;
mod study;

pub use error::ReportError;
pub use gallery::gallery;
pub use modes::{ModeCurves, ModesFigure};
pub use record::{Look, RecordCurve, RecordFigure, RecordPanel};
pub use response::{ResponseCurve, ResponseFigure};
pub use response_study::response_page;
pub use stability::StabilityMap;
pub use study::{StudyHead, StudyPage, answer_svg};
