//! The rig: ducts in a chain, named parts on them, two ends, and instruments. A network file with names. Must
//! not know stages or observations.

mod elements;
mod gas;
mod open;
mod oscilos;
mod part;
mod place;
mod read;
mod resolve;
mod value;
mod whole;

pub use gas::GasModel;
pub use part::{Duct, Instruments, Part, Shape};
pub use resolve::{DuctAt, PartAt, RigAtPoint};
pub use value::Value;
pub(crate) use value::{interpolate, number, pairs};
pub use whole::Rig;
