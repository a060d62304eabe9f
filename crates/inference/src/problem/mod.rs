//! The question: what is unknown and what was known of it before (`prior`, `parameter`, `parameters`), what
//! was measured with which noise (`data`, `block_noise`, `structured`), and what a model predicts
//! (`forward`).
//!
//! Knows no likelihood, no search and no answer.

mod alias;
mod block_noise;
mod data;
mod forward;
mod images;
mod kernelled;
mod misfit;
mod parameter;
mod parameters;
mod prior;
mod scale;
mod score;
mod structured;

pub use alias::{Alias, Move};
pub use data::{Data, NoiseGroup, NoiseMode, Observation, relative_noise};
pub use forward::{Forward, Prediction};
pub use misfit::Kernel;
pub use parameter::{Coordinates, Parameter};
pub use parameters::Parameters;
pub use prior::Prior;
pub(crate) use prior::gaussian;
pub use structured::{Correlated, Structured, complex_columns};

pub(crate) use block_noise::BlockNoise;
pub(crate) use images::Images;
pub(crate) use kernelled::Kernelled;
