#![doc = include_str!("../README.md")]

mod acoustics;
mod apparatus;
pub mod bench;
mod records;
mod toml_file;
mod truth;

pub use acoustics::{duct, obstacle, radiation, walls};
pub use apparatus::base::base_state;
pub use apparatus::open_ends::open_ends;
pub use records::faults::BadRecord;
pub use records::virtual_rig::VirtualRig;
pub use toml_file::TruthFault;
pub use truth::{
    Channels, Ends, Faults, Flow, HeaterTruth, LabError, Loudspeaker, NoiseLevels, ProngSurface, Recorder,
    Thermocouples, TrueTemperatures, Truth, WallTruth,
};
