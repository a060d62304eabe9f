//! Numbers of any sampled signal: fast kernels, transforms, noise and its whitening. Must not know pings or
//! clicks.

pub(crate) mod climb;
pub(crate) mod kernels;
mod mains;
pub(crate) mod noise;
pub(crate) mod parabola;
pub(crate) mod scaled;
pub(crate) mod transform;
