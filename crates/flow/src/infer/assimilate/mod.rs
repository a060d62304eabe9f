//! From click arrival times to the base state: assimilation with honest certainty.
//!
//! * [`Batch`]: the most probable unknowns given all clicks of all powers, transients included, and the
//!   posterior around them with the bounds of the priors. The default, and the cheapest. 2 sd cover U_h, the
//!   sound speed and the identifiable unknowns in 91 to 97 % of 200 twins (docs/records/flow.md).
//! * [`smooth`]: ES-MDA, an ensemble smoother, free of derivatives.
//! * [`filter`]: the ensemble Kalman filter that the paper describes, and variants that repair parts of it.
//!   Its error bars are too small; it is here to be compared.
//!
//! All three infer normal scores: every unknown has a standard normal score whose image is the physical value
//! ([`physical`]), so a uniform prior is kept exactly and its bounds cannot be crossed. Knows nothing of
//! settled states.

mod ambient;
mod batch;
mod ensemble;
mod estimate;
mod files;
mod infer;
mod record;
mod run;
mod twin;

pub use super::health::{FlowHealth, FlowWarning};
pub use super::report::{
    AssimilationMethod, NamedStates, PointReport, PowerReport, ResidualReport, RunReport, SnapshotReport,
    UnknownReport,
};
pub use super::scores::physical;
pub use super::sensor::{Sensor, SensorKind};
pub use super::tension::ClosureTension;
pub use ambient::{Ambient, smooth_ambient};
pub use batch::model::Batch;
pub use ensemble::filter::{FilterOptions, FilterRun, Snapshot, Variant, filter};
pub use ensemble::smoother::smooth;
pub use estimate::Estimate;
pub use files::Records;
pub use infer::{OverTime, infer, twins};
pub use record::{FlowRecord, Sample};
pub use run::assimilate;
pub use twin::{Twin, TwinOptions, staircase};

/// What twin experiments say of each method's error bars (docs/records/flow.md): share of twins within two
/// sd, p of the ranks, rms error over sd, rms error in units of the prior sd or m/s, and posterior over prior
/// sd. CSV with a header.
pub const CALIBRATION: &str = include_str!("calibration.csv");
