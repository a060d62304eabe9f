#![doc = include_str!("../README.md")]

mod draw;
mod files;
mod flow;
mod folder;
mod gallery;
mod live;
mod modes;
mod pdf;
mod plot;
mod response;
mod response_study;
mod study;

pub use draw::escape;
pub use files::{is_file_of_figures, write_figure, write_figure_as};
pub use flow::flow_page;
pub use folder::{draw_study, write_response_page};
pub use gallery::Gallery;
pub use live::{LivePage, LivePart};
pub use modes::ModesFigure;
pub use pdf::pdf;
pub use plot::plot_svg;
pub use response::{ResponseCurve, ResponseFigure};
pub use study::{StudyHead, StudyPage, answer_svg};
