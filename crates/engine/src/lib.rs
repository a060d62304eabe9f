//! A study as one trainable, predicting model: stages, competition by evidence. Must not know figures.
//!
#![doc = include_str!("../README.md")]
//!
//! # Conventions
//!
//! s = sigma + i omega, time dependence e^(st); SI units; evidence in nats. Numbers of an observation are growth rate, angular
//! frequency, then real and imaginary part of every pressure relative to the reference microphone.

mod assembly;
mod conditions;
mod data;
mod error;
mod errors;
mod noise;
mod observed;
mod point;
mod prediction;
mod predictor;
pub mod response;
pub mod run;
mod saved;
mod shape;
mod spectrum;
mod training;

pub use assembly::Assembly;
pub use conditions::Conditions;
pub use error::EngineError;
pub use noise::{LawError, Misfit, Noise, Varying};
pub use observed::Observed;
pub use point::PointModel;
pub use prediction::{PointPrediction, TrainedPosterior};
pub use predictor::Predictor;
pub use saved::SavedModel;
pub use shape::ShapeModel;
pub use spectrum::{ModeDetails, Spectrum};
pub use training::{Knowledge, Trained, Training, train};
