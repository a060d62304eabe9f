//! The gas at one operating point, and a reading of it.

use crate::base::Cause;

/// What one operating point brings to the model of the heated gas.
pub(super) struct Heated {
    pub(super) ambient: [f64; 2],
    /// Of the error of the ambient temperature.
    pub(super) cause: Cause,
    /// kg/s.
    pub(super) mass_flow: f64,
    /// Rise for eta = 1, K, and where.
    pub(super) rise: f64,
    pub(super) at: f64,
    /// 1/m for h = 1.
    pub(super) cooling: f64,
}

impl Heated {
    /// Temperature at `x` and its derivatives in eta and h.
    pub(super) fn temperature(&self, x: f64, [eta, h]: [f64; 2]) -> [f64; 3] {
        if x <= self.at || self.rise == 0.0 {
            return [self.ambient[0], 0.0, 0.0];
        }
        let d = x - self.at;
        let decay = (-h * self.cooling * d).exp();
        [
            self.ambient[0] + eta * self.rise * decay,
            self.rise * decay,
            -eta * self.rise * self.cooling * d * decay,
        ]
    }
}

/// The places of readings, m, in order: those of the thermometers.
pub(super) fn places(readings: &[GasReading]) -> Vec<f64> {
    let mut places: Vec<f64> = readings.iter().map(|r| r.at).collect();
    places.sort_by(f64::total_cmp);
    places.dedup();
    places
}

/// A reading of a thermometer.
#[derive(Clone, Debug, PartialEq)]
pub struct GasReading {
    /// Operating point, by its place in the campaign.
    pub point: usize,
    /// Place, m.
    pub at: f64,
    /// Temperature, K.
    pub temperature: f64,
    /// Its standard deviation, K.
    pub sd: f64,
}
