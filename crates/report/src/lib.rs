#![doc = include_str!("../README.md")]

mod flow;
mod folder;
mod gallery;
mod live;
mod modes;
mod response;
mod response_study;
mod study;

pub use flow::flow_page;
pub use folder::{draw_study, write_response_page};
pub use gallery::Gallery;
pub use live::{LivePage, LivePart};
pub use modes::ModesFigure;
pub use response::{ResponseCurve, ResponseFigure};
pub use study::{StudyHead, StudyPage, answer_svg};
