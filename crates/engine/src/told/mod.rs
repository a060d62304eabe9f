//! What a program says of what was found, in sentences. Knows records, and neither how they were found nor
//! files.

mod doubts;
mod foresight;
mod responses;
mod search;
mod stage;

pub use doubts::{not_identified, reasons, warn_of_prior};
pub use foresight::tell_foresight;
pub use responses::tell_responses;
pub use stage::{tell_heat, tell_stage};
