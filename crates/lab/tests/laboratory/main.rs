//! The laboratory: its bench and its records.

mod bench;
mod records;
