//! Formats: from the bytes of WAV, text, MATLAB and HDF5 files to numbers with names, and back.
//!
//! Knows neither microphones nor records; a heading is a name with a unit.

pub(crate) mod array;
pub(crate) mod arrays;
pub(crate) mod columns;
#[cfg(feature = "hdf5")]
mod hdf5;
pub(crate) mod headings;
mod labview;
mod mat5;
pub(crate) mod numbers;
pub(crate) mod riff;
mod stamp;
pub(crate) mod text;
pub(crate) mod wav;
