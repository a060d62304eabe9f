//! A click: one impulse at every channel, and its arrival times. Must not know other records.

mod end;
mod extent;
mod fit;
mod hum;
mod leaning;
mod model;
mod options;
mod picture;
mod pulse;
mod segment;
mod steps;
mod waveform;

pub use extent::Extent;
pub use fit::{fit_click, picture_click};
pub use options::{ClickFit, ClickOptions, Reflection};
pub use picture::ClickPicture;
