//! Evidence for the network: closed forms, an independent reference file, an independent chain in jets,
//! invariances.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
#![allow(clippy::print_stdout, reason = "long studies print what the records keep")]

mod adjoint;
mod along;
mod bias;
mod certificate;
mod chains;
mod common_laws;
mod constants;
mod continued;
mod derivatives;
mod eigenvalues;
mod elements;
mod files;
mod flow_adjoint;
mod forced;
mod fuzz;
mod gases;
mod ghosts;
mod holes;
mod invariances;
mod mean_flow;
mod oscilos;
mod pieces;
mod ranges;
mod refusals;
mod row;
mod slope_in_flow;
mod spread;
