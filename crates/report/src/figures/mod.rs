//! One module per study: its figures, its tables, and what the page says about it.

pub(crate) mod campaign;
pub(crate) mod consistency;
pub(crate) mod empty_tube;
pub(crate) mod lumped;
pub(crate) mod microphones;
pub(crate) mod prongs;
