//! The rig at one operating point with lengths, areas, temperatures and places that may be unknown. Every
//! duct holds gas of one temperature, at rest. Must not know what was measured.

mod extents;
mod fill;
mod gas;
mod model;
mod moving;
mod waves;

pub(crate) use fill::FilledShape;
pub(crate) use model::LawOf;
pub use model::ShapeModel;
pub(crate) use moving::Moving;
