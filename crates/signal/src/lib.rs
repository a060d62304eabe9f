#![doc = include_str!("../README.md")]

mod blow;
mod campaign;
mod channel;
mod click;
mod delays;
mod dsp;
mod error;
mod mishap;
mod order;
mod padding;
mod ping;
mod random;
mod readings;
mod repeats;
mod ringdown;
mod steady;
mod trace;
mod unstable;
mod words;

pub use blow::{BlowFit, BlowMode, BlowOptions, CombinedBlows, combine_blows, fit_blow};
pub use campaign::{
    Kept, LiveRecord, PointScatter, ProcessError, ProcessOptions, Processed, click_options, process,
    process_again, record_count,
};
pub use channel::Channel;
pub use click::{ClickFit, ClickOptions, ClickPicture, Extent, Reflection, fit_click, picture_click};
pub use delays::{CalibrationError, ChannelDelays, ChannelPriors, KnownClick};
pub use error::Fault;
pub use mishap::Mishap;
pub use order::{ChannelExchange, OutOfOrder};
pub use ping::{
    Drift, Excess, Excesses, MajorityFit, PingFit, PingOptions, PingPicture, fit_majority, fit_ping,
};
pub use random::{
    ChannelGains, ComparedChannels, ComparisonFault, Field, GainPair, LossBand, PressureFault,
    RelativePressures, Spectra, Swept, SweptOptions, SwitchedDoubt, SwitchedFault, SwitchedGains,
    TransferEstimate, TransmissionLoss, TransmissionTube, Transmitted, TubeDuct, TubeErrors,
};
pub use readings::TwoReadings;
pub use repeats::{Repeats, combine, pool};
pub use steady::SteadyTone;
pub use trace::Trace;
pub use unstable::Unstable;
