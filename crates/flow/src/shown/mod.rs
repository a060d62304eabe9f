//! What is shown of inferred flows: sentences, tables and figures, as text and numbers. Knows what was found,
//! and neither how it was found nor how a figure is drawn.

mod document;
mod figures;
mod tables;
mod words;

pub use document::FlowDocument;
pub use figures::{FlowCalibration, base_flow, filters};
pub use tables::{unknowns_table, velocity_table};
pub use words::{settles, together, words};
