//! A folder of records: `manifest.toml` with the words of its keys, and the files that it lists, read one at
//! a time.
//!
//! Knows nothing of what is made of the records.

pub(crate) mod arrivals;
pub(crate) mod folder;
mod keys;
mod microphones;
mod resolve;

pub(crate) use keys::{Listed, MicrophoneKeys};
pub(crate) use microphones::Channels;
pub(crate) use resolve::full_scale;
