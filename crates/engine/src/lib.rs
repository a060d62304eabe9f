#![doc = include_str!("../README.md")]

mod assembly;
mod conditions;
mod data;
mod delays;
mod error;
mod errors;
pub mod folder;
mod gaussian;
mod groups;
mod noise;
mod observed;
mod point;
mod prediction;
mod predictor;
pub mod response;
mod rows;
pub mod run;
mod saved;
mod shape;
mod spectrum;
pub mod told;
mod training;

pub use assembly::Assembly;
pub use conditions::{Conditions, Displaced};
pub use error::EngineError;
pub use gaussian::{NamedGaussian, Training};
pub use noise::{Added, LawError, Misfit, Noise, Varying};
pub use observed::Observed;
pub use point::{BeyondTable, PointModel};
pub use prediction::{PointPrediction, TrainedPosterior};
pub use predictor::Predictor;
pub use saved::SavedModel;
pub use shape::ShapeModel;
pub use spectrum::{ModeDetails, Spectrum};
pub use training::{Trained, train};
