//! Models trained on forced responses: the rig at rest in uniform gas, with unknown lengths, areas and
//! places, seen through a measuring head whose errors are integrated over, or heard by microphones while
//! sources of unknown strength drive it.

mod about;
mod aliases;
mod channels;
mod data;
mod errors;
mod forecast;
mod foresight;
mod ground;
mod head;
mod measured;
mod mistaken;
mod noise;
mod predict;
mod record;
mod residual;
mod rows;
mod select;
mod sources;
mod stage;
mod stray;
mod train;
mod turned_time;
mod untold;

/// Groups of noise by name: of every number, in two parts where the data ask for them, of the model, and the
/// frequencies along which that of the model is alike.
pub(crate) const NOISE: &str = "noise";
pub(crate) const IN_PROPORTION: &str = "noise in proportion to the modulus";
pub(crate) const OF_QUOTIENT: &str = "noise in proportion to 1 + |H|^2";
pub(crate) const OF_ONE_SIZE: &str = "noise of one size at all levels";
const MISFIT: &str = "misfit";
const LENGTH_OF_MISFIT: &str = "length of the misfit";

pub use forecast::ResponseForecast;
pub(crate) use forecast::trained_band;
pub use ground::{Ground, GroundModel};
pub use record::{ForeseenModel, LoadRecord, ResponseForesight, ResponseModelRecord, ResponseStageRecord};
pub(crate) use rows::rows_of;
pub use stage::ResponseRun;
