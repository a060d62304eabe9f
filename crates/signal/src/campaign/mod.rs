//! All records of a campaign: calibration, pings and clicks, means over repeats. Knows every other folder.

mod calibration;
mod contradictions;
mod copies;
mod disagreeing;
mod drifts;
mod excesses;
mod extrapolated;
mod fitted;
mod gains;
mod gathered;
mod kept;
mod left_out;
mod live;
mod loud;
mod odd;
mod options;
mod path;
mod polarity;
mod process;
mod rates;
mod repeated;
mod travel;

pub use kept::Kept;
pub use live::LiveRecord;
pub use options::{PointScatter, ProcessError, ProcessOptions, Processed};
pub use path::click_options;
pub(crate) use path::kirchhoff;
pub use process::{process, process_again, record_count};
