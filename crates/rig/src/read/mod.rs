//! Reading records: what the manifest says of a file is held against what the file has, and its numbers
//! become pressures, a block at a time.
//!
//! Knows one file at a time; folders of records are the manifest's.

mod array_record;
mod blocks;
mod clock;
pub(crate) mod contents;
mod gather;
pub(crate) mod layout;
mod plan;
pub(crate) mod record;
pub(crate) mod span;
