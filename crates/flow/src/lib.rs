#![doc = include_str!("../README.md")]

mod apparatus;
mod base;
mod error;
mod infer;
mod number;
pub mod shown;
mod tube;

pub use apparatus::campaign::TubeCampaign;
pub use apparatus::folder::HeatedTube;
pub use apparatus::geometry::{Insert, Plates, Tube, TubeRecording, TubeRig};
pub use apparatus::observed::{ObservedTube, TubeObservations};
pub use apparatus::point::{PLATES, POSITION, POWER, THERMOMETERS, TubePoint};
pub use apparatus::ramp::{Logged, Ramp};
pub use base::profiles::{PROFILES, VELOCITIES, read_profiles};
pub use base::state::{BaseState, ErrorComponent};
pub use base::states::BaseStates;
pub use error::FlowError;
pub use infer::{assimilate, settled};
pub use number::{Dual, Lanes, Number, Single};
pub use tube::closures::Closures;
pub use tube::draught::{Balanced, Draught};
pub use tube::march::{Drive, March};
pub use tube::parameters::{TubeParameters, UNKNOWNS, Unknowns, unknowns};
pub use tube::pipe::Pipe;
pub use tube::steady::{SENSITIVE_TO, Sensitivity, Steady};
pub use tube::transient::{Implicit, Transient};
pub use tube::wall::HeatBalance;
