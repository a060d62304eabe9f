//! The laboratory as a source of records: pings, clicks and sweeps of the tube as microphones, channels and
//! the recorder give them, with noise and faults.
//!
//! Knows the tube as its modes and times; takes them from the apparatus.

mod click;
pub(crate) mod faults;
mod noise;
mod ping;
mod setup;
pub(crate) mod source;
mod sweep;
pub(crate) mod virtual_rig;
mod write;
