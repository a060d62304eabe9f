#![doc = include_str!("../README.md")]

mod check;
mod compared;
mod driven;
mod excited;
mod flow;
mod foreseen;
mod made;
mod observe;
mod plots;
mod switched;

pub use check::check_records;
pub use excited::Excited;
pub use flow::{FlowOptions, InferredFlow, flow_is_due};
pub use foreseen::foresee;
pub use observe::{Intake, ObserveOptions, Out, described};
pub use plots::Shown;

/// Opens the folder of a study: [`rijke_study::Study::open`], or a function that also checks what is asked.
pub type OpenStudy<'a> = &'a dyn Fn(&std::path::Path) -> Result<rijke_study::Study, rijke_numerics::Failed>;
