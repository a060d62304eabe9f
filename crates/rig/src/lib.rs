//! The apparatus and what it measured: geometry, gas, instruments, the campaign of operating points, raw
//! records, pings and clicks, and the files that hold them. Knows no model.
//!
//! * [`Rig`], [`Campaign`]: what was built and what was measured, from TOML files.
//! * [`RecordSource`]: raw records, one at a time; [`RecordFolder`] reads them from a manifest and its files:
//!   WAV, text, MATLAB, and HDF5 with the feature `hdf5` (on by default).
//! * [`Observations`]: pings and clicks with covariances, to and from CSV.
//! * [`Columns`]: tables of numbers by the names and units of their columns.
//! * [`Acquisition`], [`Reading`]: how files are written and what is known of the channels, where a manifest
//!   says so.
//! * [`Unit`], [`Quantity`], [`Heading`], [`Given`]: units in headings and keys, converted once where they
//!   are read.
//!
//! # Conventions
//!
//! * SI units; a suffix in a file's key where a unit could be doubted (`power_w`, `positions_cm`).
//! * x runs upward along the tube, x = 0 at the bottom (upstream) end.
//! * Time dependence e^{st}, s = sigma + i omega: growth rate in 1/s (negative decays), angular frequency in
//!   rad/s.
//! * Pressures of a ping are relative to the reference microphone.
//! * Microphones, channels and repeats are counted from 0 in code and in TOML; the columns of a CSV file
//!   (`p1_re`) count from 1.
//!
//! # Example
//!
//! ```
//! use rijke_rig::{Campaign, Rig};
//! let (rig, campaign) = (Rig::juniper_yoko_2022(), Campaign::juniper_yoko_2022());
//! assert_eq!(campaign.points.len(), 175);
//! let air = rig.gas.at(293.15, rig.pressure);
//! assert!((air.sound_speed - 343.3).abs() < 0.1);
//! ```

mod acquisition;
mod arrays;
mod blocks;
mod campaign;
mod channels;
mod columns;
mod contents;
mod dead;
mod error;
mod excited;
mod files;
mod gas;
mod geometry;
#[cfg(feature = "hdf5")]
mod hdf5;
mod manifest;
mod mat5;
mod observation;
mod problem;
mod reading;
mod records;
mod riff;
mod span;
mod table;
mod text;
mod units;
mod wav;
mod words;

pub use acquisition::{Acquisition, Exception, StatedChannels};
pub use arrays::{Arrays, named_columns};
pub use campaign::{Campaign, OperatingPoint};
pub use channels::ChannelErrors;
pub use columns::Columns;
pub use contents::{ChannelContents, FileContents, inspect};
pub use error::{Elsewhere, RigError};
pub use excited::{Blow, BlowState, Excitation, ExcitedRecords, RandomNoise, Specimen, SwitchedRecord};
pub use gas::{Gas, GasState};
pub use geometry::{Insert, Microphones, Plates, Recording, Rig, Tube};
pub use manifest::RecordFolder;
pub use observation::{Click, Observations, Ping, PointObservations, Rejection};
pub use problem::Problem;
pub use reading::{Column, Reading};
pub use records::{Calibration, DataKind, Day, PointRecords, Record, RecordSet, RecordSource, Stretch};
pub use span::{Event, read_event};
pub use text::{Decimal, TextForm};
pub use units::{Given, Heading, Quantity, Unit, UnitError};
pub use wav::{Layout, Samples24, read_record};
