//! Records: what one is, what a set of them is, how its files are written and what is known of the channels.
//!
//! Opens no file of samples.

pub(crate) mod acquisition;
pub(crate) mod item;
pub(crate) mod reading;
pub(crate) mod record;
pub(crate) mod set;
