//! One module per study: its figures, its tables, and what the page says about it.

pub(crate) mod base_flow;
pub(crate) mod campaign;
pub(crate) mod cold;
pub(crate) mod consistency;
pub(crate) mod empty_tube;
pub(crate) mod feedback;
pub(crate) mod flow_numerics;
pub(crate) mod heat_release;
pub(crate) mod lumped;
mod measured;
pub(crate) mod microphones;
mod powers;
pub(crate) mod predictions;
pub(crate) mod prongs;
mod ranking;
pub(crate) mod truths;
