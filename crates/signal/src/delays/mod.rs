//! Delays and gains of the channels: from clicks at a known speed of sound, or stated. Must not know
//! campaigns.

mod channels;
mod error;
mod left;
mod order;
mod place;
mod stated;

pub(crate) use channels::GAIN_SPREAD;
pub use channels::{ChannelDelays, KnownClick};
pub use error::CalibrationError;
pub(crate) use order::exchanged;
pub use stated::ChannelPriors;
