//! Models trained on forced responses: the rig at rest in uniform gas, with unknown lengths, areas and
//! places, seen through a measuring head whose errors are integrated over, or heard by microphones while
//! sources of unknown strength drive it.

mod data;
mod foresight;
mod head;
mod measured;
mod predict;
mod record;
mod residual;
mod select;
mod sources;
mod stage;
mod train;

pub use record::{ForeseenModel, LoadRecord, ResponseForesight, ResponseModelRecord, ResponseStageRecord};
pub use stage::ResponseRun;
