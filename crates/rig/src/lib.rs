//! The apparatus and what it measured: geometry, gas, instruments, the campaign of operating points, raw
//! records, pings and clicks, and the files that hold them. Knows no model.
//!
//! # Conventions
//!
//! * SI units; a suffix in a file's key where a unit could be doubted (`power_w`, `heater_position_m`).
//! * x runs upward along the tube, x = 0 at the bottom (upstream) end.
//! * Time dependence e^{st}, s = sigma + i omega: growth rate in 1/s (negative decays), angular frequency in rad/s.
//! * Pressures of a ping are relative to the reference microphone.

mod campaign;
mod gas;
mod geometry;
mod observation;

pub use campaign::{Campaign, OperatingPoint};
pub use gas::{Gas, GasState};
pub use geometry::{Heater, Microphones, Prongs, Recording, Rig, Tube};
pub use observation::{Click, Ping, Rejection};
