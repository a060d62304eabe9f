//! Files that people and systems write, and what is said of bad ones.

mod arrays;
mod columns;
mod damaged;
mod excited;
mod long;
mod manifest;
mod observations;
mod round_trips;
mod units;
mod written;
