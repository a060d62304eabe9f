//! From microphone records to pings and clicks with uncertainties; useful for any ring-down or time of flight
//! recorded on several channels. Knows no model.
//!
//! * [`fit_ping`]: one complex frequency and a mode shape from a ring-down.
//! * [`fit_click`]: arrival times of one impulse at all channels.
//! * [`fit_blow`]: several modes of a record that begins with a blow.
//! * [`ChannelDelays`]: delays and gains of the channels, learnt from impulses at a known speed of sound, and removed.
//! * [`combine`]: the mean over repeats, scatter within and between them, drift, outliers; [`pool`]: the same scatter
//!   learnt from all points.
//! * [`process`]: all of this for the records of a campaign.
//! * [`Spectra`]: transfer functions between channels in random noise; [`SwitchedGains`]: gains of channels from records in which two have changed
//!   places; [`TransmissionTube`]: what a specimen lets through.
//!
//! A record that must not be used is refused with a [`Fault`] that says why. The theory is in `docs/theory/signal.md`.
//!
//! # Conventions
//!
//! * Time dependence e^{st}, s = sigma + i omega: growth rate sigma in 1/s (negative decays), omega in rad/s.
//! * A [`Trace`] is a slice of channels of equal length; channels count from 0.
//! * Covariances are of real vectors; a complex number counts as its real part, then its imaginary part.
//! * A channel delay d means that the record shows p(t - d).
//!
//! # Example
//!
//! ```
//! use rijke_signal::{PingOptions, Trace, fit_ping};
//! // Two channels of a ring-down at 170 Hz that begins after 0.1 s, in a little noise.
//! let noise = |n: usize, m: usize| (((n * 7919 + m * 104_729) % 10_007) as f64 / 10_007.0 - 0.5) * 1e-3;
//! let channel = |m: usize| -> Vec<f64> {
//!     let ring = |n: usize| {
//!         let t = n as f64 / 1e4 - 0.1;
//!         if t < 0.0 { 0.0 } else { (1.0 - 0.4 * m as f64) * (-12.0 * t).exp() * (1068.0 * t).cos() }
//!     };
//!     (0..8000).map(|n| ring(n) + noise(n, m)).collect()
//! };
//! let channels = [channel(0), channel(1)];
//! let trace = Trace { channels: &channels, rate_hz: 1e4, quiet: 1000, full_scale: f64::INFINITY };
//! let fit = fit_ping(&trace, &PingOptions::default())?;
//! assert!((fit.ping.s.re + 12.0).abs() < 0.01 && (fit.ping.s.im - 1068.0).abs() < 0.01);
//! assert!((fit.ping.pressures[1].re - 0.6).abs() < 1e-3);
//! # Ok::<(), rijke_signal::Fault>(())
//! ```

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
