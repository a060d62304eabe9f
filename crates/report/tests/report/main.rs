//! Pages and figures.

mod page;
mod pdf;
