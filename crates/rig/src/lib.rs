#![doc = include_str!("../README.md")]

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

pub use apparatus::campaign::{Campaign, OperatingPoint};
pub use apparatus::gas::{Gas, GasState};
pub use apparatus::geometry::{Insert, Microphones, Plates, Recording, Rig, Tube};
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
