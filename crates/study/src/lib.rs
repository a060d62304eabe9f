#![doc = include_str!("../README.md")]

mod ambient;
mod base;
mod campaign;
mod catalogue;
mod claims;
mod doubtful;
mod error;
mod folder;
mod foreseen;
mod head;
mod heated;
mod law;
mod modes;
pub mod names;
mod one_table;
pub mod plan;
mod records;
pub mod responses;
mod rig;
mod source;
mod states;

pub use base::{BaseError, Cause, GasStretch, PointState, Sharing};
pub use campaign::{Campaign, Factor, Point, SURROUNDINGS};
pub use catalogue::Catalogue;
pub use claims::{ClaimNumber, Claims, Statement, Take};
pub use error::{StudyError, StudyProblem};
pub use folder::Study;
pub use foreseen::{States, Unforeseen};
pub use head::ErrorTerm;
pub use heated::{GasReading, HeatedFit, heated_states, read_readings};
pub use law::{Candidate, Coefficient, Effect, Hears, MeanFlow, Place, Spread};
pub use modes::{ObservedMode, ObservedModes, hertz, read_modes};
pub use one_table::OneTable;
pub use rig::{Duct, DuctAt, GasModel, Instruments, PIECES, Part, PartAt, Rig, RigAtPoint, Shape, Value};
pub use states::{ErrorRecord, StateRecord, StatesFile, read_states};
