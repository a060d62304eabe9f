//! From microphone records to pings and clicks with uncertainties; useful for any ring-down or time of flight
//! recorded on several channels. Knows no model.
//!
//! [`fit_ping`] makes one complex frequency and a mode shape from a ring-down; a record that must not be used is
//! refused with a [`Fault`] that says why.
//!
//! # Conventions
//!
//! * Time dependence e^{st}, s = sigma + i omega: growth rate sigma in 1/s (negative decays), omega in rad/s.
//! * A [`Trace`] is a slice of channels of equal length; channels count from 0.
//! * Covariances are of real vectors; a complex number counts as its real part, then its imaginary part.
//! * A channel delay d means that the record shows p(t - d).

mod campaign;
mod click;
mod delays;
mod error;
mod forcing;
mod noise;
mod pencil;
mod ping;
mod pulse;
mod repeats;
mod ringdown;
mod segment;
mod trace;
mod verdict;
mod waveform;

pub use campaign::{PointScatter, ProcessError, ProcessOptions, Processed, process, record_count};
pub use click::{ClickFit, ClickOptions, Reflection, fit_click};
pub use delays::{CalibrationError, ChannelDelays, KnownClick};
pub use error::Fault;
pub use ping::{PingFit, PingOptions, fit_ping};
pub use repeats::{Repeats, combine};
pub use trace::Trace;
