//! Chosen candidates, the base state of the flow and an acoustic network as one model that predicts what microphones
//! measure, trains on observations and saves itself.
//!
//! * [`Assembly`]: a rig, one candidate per role, and what is held fixed. It knows which parameters are free.
//! * [`PointModel`]: the assembly at one operating point: a network whose coefficients are the candidates' laws.
//! * [`Predictor`]: many points as one forward model for `rijke_inference`, with exact derivatives, in parallel.
//! * [`Noise`] and [`data_of`]: observations as data of an inference.
//! * [`train`]: the most probable parameters, their covariance and the evidence.
//! * [`BaseErrors`]: what the base flow's uncertainty does to the predictions, shared between operating points.
//! * [`Knowledge::predict`], [`SavedModel`]: predictions with uncertainty at any operating point; a trained model on disk.
//!
//! # Conventions
//!
//! * s = sigma + i omega, time dependence e^{st}; growth rate in 1/s, angular frequency in rad/s; SI units.
//! * The predicted numbers of a point are sigma, omega, then real and imaginary part of the pressure at each microphone
//!   but the reference, relative to the reference: the order of `rijke_rig::Ping::vector`.
//! * Wall loss lives in the propagation ([`Scheme::Line`]); the paper's lumped jumps are [`Scheme::Lumped`].
//! * All derivatives come from the network's adjoints and the jets of the laws; no finite differences.

mod assembly;
mod base;
mod channels;
mod common;
mod data;
mod elements;
mod error;
mod fill;
mod law_error;
mod noise;
mod numbers;
mod point;
mod prediction;
mod predictor;
mod principal;
mod saved;
mod sensitivity;
mod systematic;
mod training;
mod varying;

pub use assembly::{Assembly, Scheme};
pub use base::Conditions;
pub use data::{Observed, data_of, hears_near_field, selected};
pub use error::ModelError;
pub use noise::{Misfit, Noise};
pub use point::PointModel;
pub use prediction::PointPrediction;
pub use predictor::Predictor;
pub use rijke_flow::{BaseState, BaseStates};
pub use rijke_network::{Response, Workspace};
pub use saved::{SavedCandidate, SavedModel};
pub use systematic::BaseErrors;
pub use training::{Knowledge, Trained, Training, train};
pub use varying::Varying;
