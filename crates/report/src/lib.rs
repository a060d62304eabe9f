#![doc = include_str!("../README.md")]

mod draw;
mod error;
mod gallery;
mod modes;
mod pdf;
mod record;
mod response;
mod response_study;
mod study;

pub use draw::escape;
pub use error::ReportError;
pub use gallery::gallery;
pub use modes::{ModeCurves, ModesFigure};
pub use pdf::pdf;
pub use record::{Look, RecordCurve, RecordFigure, RecordPanel};
pub use response::{ResponseCurve, ResponseFigure};
pub use response_study::response_page;
pub use study::{StudyHead, StudyPage, answer_svg};
