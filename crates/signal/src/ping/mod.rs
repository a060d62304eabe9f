//! A ping: noise, forcing, and the free decay of one mode. Must not know other records.

mod alike;
mod backwards;
mod chirp;
mod diagnosis;
mod driven;
mod excess;
mod fairest;
mod fit;
mod forcing;
mod found;
mod heard;
mod judged;
mod lines;
mod majority;
mod options;
mod picture;
mod power;
mod relative;
mod resolution;
mod rest;
mod ringing;
mod search;
mod silence;
mod slope;
mod verdict;

pub use chirp::Drift;
pub use excess::{Excess, Excesses};
pub use fit::fit_ping;
pub use found::PingFit;
pub use majority::{MajorityFit, fit_majority};
pub use options::PingOptions;
pub use picture::PingPicture;
