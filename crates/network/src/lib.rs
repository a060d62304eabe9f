#![doc = include_str!("../README.md")]

mod chain;
mod chains;
mod error;
pub mod file;
pub mod flow_chain;
pub mod laws;
mod modes;
mod plane;
mod respond;
mod sense;
mod slot;

pub use chain::coefficients::{At, Coefficients, Constant, Laws, Pole};
pub use chain::network::{Network, Segment};
pub use chain::workspace::Workspace;
pub use chains::Chain;
pub use error::NetworkError;
pub use laws::{levine_schwinger, wall};
pub use plane::modes::{Mode, Modes};
pub use plane::newton::{Newton, Root};
pub use plane::region::Region;
pub use plane::tracking::follow;
pub use plane::zeros::zeros_of;
pub use respond::answer::{Places, Response};
pub use respond::forced::{Forced, Source, Transfer};
pub use sense::advice::{BestPlace, SmallChange};
pub use sense::along::{Device, Station};
pub use sense::budget::{Budget, Power};
pub use sense::curves::{Advice, ModeCurves};
pub use sense::sensitivity::{Derivatives, Sensitivities};
pub use slot::Slot;
