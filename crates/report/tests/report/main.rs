//! Pages and figures.

mod page;
