//! What a program says of what was found, in sentences. Knows records, and neither how they were found nor
//! files.

mod doubts;
mod foresight;
mod next;
mod responses;
mod search;
mod stage;

pub use doubts::{not_identified, reasons};
pub use foresight::tell_foresight;
pub use responses::tell_responses;
pub use stage::{doubts_of_stage, not_decided, tell_heat, tell_stage};
