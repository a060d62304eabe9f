//! Pages and figures.

mod figures;
mod page;
