//! What signal processing makes of one record.

use rijke_numerics::{C64, Matrix};

/// One ring-down: complex frequency and mode shape, with their covariance.
#[derive(Clone, Debug, PartialEq)]
pub struct Ping {
    /// s = sigma + i omega; growth rate in 1/s, angular frequency in rad/s.
    pub s: C64,
    /// Complex pressure at each microphone, relative to the reference microphone (whose entry is 1).
    pub pressures: Vec<C64>,
    /// Index of the reference microphone.
    pub reference: usize,
    /// Covariance of [`Ping::vector`]. Full: relative pressures share the noise of the reference microphone.
    pub covariance: Matrix,
}

impl Ping {
    /// The real numbers measured: sigma, omega, then real and imaginary part of every pressure but the reference's.
    #[must_use]
    pub fn vector(&self) -> Vec<f64> {
        let others = self.pressures.iter().enumerate().filter(|(m, _)| *m != self.reference);
        [self.s.re, self.s.im].into_iter().chain(others.flat_map(|(_, p)| [p.re, p.im])).collect()
    }
}

/// One impulse: arrival time at each microphone, with covariance.
#[derive(Clone, Debug, PartialEq)]
pub struct Click {
    /// Arrival time at each microphone after the loudspeaker's trigger, s, channel delays removed.
    pub arrival_times: Vec<f64>,
    /// Covariance of the arrival times, s^2. The error of the channel delays is part of it, and is common to all
    /// clicks that were corrected with the same calibration.
    pub covariance: Matrix,
}

/// A record that is not used, and why. Rejections are counted and listed, never averaged in.
#[derive(Clone, Debug, PartialEq)]
pub struct Rejection {
    /// Which record.
    pub record: String,
    /// Why, in words with numbers.
    pub reason: String,
}
