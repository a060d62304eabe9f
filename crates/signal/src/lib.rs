#![doc = include_str!("../README.md")]

mod backwards;
mod blow;
mod campaign;
mod chirp;
mod click;
mod delays;
mod driven;
mod end;
mod error;
mod extent;
mod forcing;
mod kernels;
mod noise;
mod parabola;
mod pencil;
mod picture;
mod ping;
mod pool;
mod pulse;
mod repeats;
mod ringdown;
mod search;
mod segment;
mod spectra;
mod switched;
mod trace;
mod transform;
mod transmission;
mod verdict;
mod waveform;

pub use blow::{BlowFit, BlowMode, BlowOptions, combine_blows, fit_blow};
pub use campaign::{
    Kept, LiveRecord, PointScatter, ProcessError, ProcessOptions, Processed, StatedChannels, click_options,
    process, process_again, record_count,
};
pub use chirp::Drift;
pub use click::{ClickFit, ClickOptions, Reflection, fit_click, picture_click};
pub use delays::{CalibrationError, ChannelDelays, KnownClick};
pub use error::Fault;
pub use extent::Extent;
pub use picture::{ClickPicture, PingPicture};
pub use ping::{PingFit, PingOptions, fit_ping};
pub use repeats::{Repeats, combine, pool};
pub use spectra::{Spectra, TransferEstimate};
pub use switched::{GainPair, SwitchedGains};
pub use trace::Trace;
pub use transmission::{TransmissionTube, Transmitted};
