//! One module per scientific question; each returns numbers that serialise, and never draws.
//!
//! # Conventions
//!
//! * SI units, angles in rad, s = sigma + i omega in 1/s and rad/s; ln of likelihoods in nats. "Per datapoint" is per
//!   operating point.
//! * Every record says in its [`Provenance`] whether its data were measured or virtual, and what was rejected.
//! * A [`Check`] is a statement of the paper's text or of an acceptance list, with the number that decides it.
//! * Standard deviations are called `sd`.

mod campaign;
mod catalogue;
mod cold;
mod competition;
mod consistency;
mod empty_tube;
mod error;
mod feedback;
mod flow_numerics;
mod heat_release;
mod heater;
mod hot;
mod hot_predictions;
mod lumped;
mod microphones;
mod prongs;
mod records;
mod setting;
mod truths;

pub use campaign::{CampaignRead, CampaignRow, PointRead, campaign};
pub use catalogue::{catalogue, chosen};
pub use cold::{ColdStage, cold};
pub use competition::{COMPETING_ROLES, Depth, Stage, Terms};
pub use consistency::consistency;
pub use empty_tube::{empty_tube, true_empty_tube};
pub use error::StudyError;
pub use feedback::{feedback, feedback_naive};
pub use flow_numerics::{FlowNumerics, FlowOrder, flow_numerics};
pub use heat_release::{Chosen, heat_release};
pub use heater::cold_heater;
pub use hot::Hot;
pub use hot_predictions::{figure_8, figure_9, figure_10, figure_11};
pub use lumped::{LumpedConvergence, LumpedRow, lumped_convergence};
pub use microphones::microphones;
pub use prongs::{prongs, prongs_stage};
pub use records::{
    Case, Check, Cold, ColdSeries, Consistency, ConsistencyRow, CurvePoint, EmptyTube, Evidence, Feedback,
    FeedbackPoint, HeatRelease, HotPoint, HotPredictions, MeasuredPoint, Microphones, ParameterName,
    ParameterValue, PredictedPoint, ProngModel, Prongs, Provenance, RejectedRecord, TruthRow, Truths,
};
pub use rijke_rig::DataKind;
pub use truths::truths;
