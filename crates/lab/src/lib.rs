//! The virtual laboratory: finer physics than any candidate, written as raw records.
