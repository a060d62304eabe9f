//! The gas at one operating point, and a reading of it.

use crate::base::Cause;

/// What one operating point brings to the model of the heated gas.
pub(super) struct Heated {
    pub(super) ambient: [f64; 2],
    /// Of the error of the ambient temperature.
    pub(super) cause: Cause,
    /// kg/s.
    pub(super) mass_flow: f64,
    /// Q/(m c_p) with c_p at the ambient temperature, K, and where.
    pub(super) rise: f64,
    pub(super) at: f64,
    /// Perimeter over m c_p, 1/m for h = 1.
    pub(super) cooling: f64,
    /// How c_p grows with temperature above ambient: c_p over its ambient value, less 1, by powers 1 to 3 of
    /// the excess in K.
    pub(super) growth: [f64; 3],
}

/// Newton steps at most; a few give all digits.
const STEPS: usize = 20;

impl Heated {
    /// Temperature at `x` and its derivatives in eta and h.
    ///
    /// With the excess y over ambient and r(y) = c_p over its ambient value: int_0^y r = eta Q/(m c_p) at
    /// the part, and dy/dx = -h P y/(m c_p r) behind it, so that q = y/y_0 has
    /// int_1^q r(q y_0) dq/q = -h P x/(m c_p).
    pub(super) fn temperature(&self, x: f64, [eta, h]: [f64; 2]) -> [f64; 3] {
        if x <= self.at || self.rise == 0.0 {
            return [self.ambient[0], 0.0, 0.0];
        }
        let first = self.excess(eta * self.rise);
        let by_h = self.cooling * (x - self.at);
        let q = self.left(first, h * by_h);
        let excess = q * first;
        let r = self.ratio(excess);
        [self.ambient[0] + excess, self.rise * q / r, -by_h * excess / r]
    }

    /// c_p over its ambient value.
    fn ratio(&self, excess: f64) -> f64 {
        let [a, b, c] = self.growth;
        1.0 + excess * (a + excess * (b + excess * c))
    }

    /// The excess whose enthalpy over the ambient c_p is `rise`.
    fn excess(&self, rise: f64) -> f64 {
        let [a, b, c] = self.growth;
        let enthalpy = |y: f64| y * (1.0 + y * (a / 2.0 + y * (b / 3.0 + y * c / 4.0)));
        let mut y = rise;
        for _ in 0..STEPS {
            let step = (enthalpy(y) - rise) / self.ratio(y);
            y -= step;
            if step.abs() <= 1e-12 * rise.abs() {
                break;
            }
        }
        y
    }

    /// The share of an excess that is left where a gas of constant c_p has exp(-`s`) of it.
    fn left(&self, first: f64, s: f64) -> f64 {
        let by = [1, 2, 3].map(|k| self.growth[k - 1] * first.powi(k as i32) / k as f64);
        let mut ln = -s;
        for _ in 0..STEPS {
            let q = ln.exp();
            let off = ln + s + (0..3).map(|k| by[k] * (q.powi(k as i32 + 1) - 1.0)).sum::<f64>();
            let step = off / self.ratio(q * first);
            ln -= step;
            if step.abs() <= 1e-12 {
                break;
            }
        }
        ln.exp()
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
