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

mod apparatus;
mod error;
mod excited;
mod files;
mod formats;
mod manifest;
mod observations;
mod problem;
mod read;
mod records;
mod units;
mod words;

pub use apparatus::campaign::Campaign;
pub use apparatus::gas::{Gas, GasState};
pub use apparatus::geometry::{Insert, Microphones, Plates, Recording, Rig, Tube};
pub use apparatus::point::OperatingPoint;
pub use apparatus::ramp::{Logged, Ramp};
pub use error::{Elsewhere, RigError};
pub use excited::{Blow, BlowState, Excitation, ExcitedRecords, RandomNoise, Specimen, SwitchedRecord};
pub use formats::arrays::named_columns;
pub use formats::columns::Columns;
pub use formats::text::{Decimal, TextForm};
pub use formats::wav::Samples24;
pub use manifest::arrivals::{Arrivals, Arrived};
pub use manifest::folder::RecordFolder;
pub use observations::channels::ChannelErrors;
pub use observations::observation::{Click, Observations, Ping, PointObservations, Rejection};
pub use problem::Problem;
pub use read::contents::{ChannelContents, FileContents, inspect};
pub use read::layout::Layout;
pub use read::record::read_record;
pub use read::span::{Event, read_event};
pub use records::acquisition::{Acquisition, Exception, StatedChannels};
pub use records::reading::{Arrays, Column, Reading};
pub use records::record::Record;
pub use records::set::{Calibration, DataKind, Day, PointRecords, RecordSet, RecordSource, Stretch};
pub use units::{Given, Heading, Quantity, Unit, UnitError};
